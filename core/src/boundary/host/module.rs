//! Is this the record of a library that can be worked with? Everything is checked before anything but the entry
//! function is called.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{read, str_from, string_from};
use crate::registry::Stage;
use std::mem::offset_of;

/// Why a library's record is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ModuleError {
    /// The entry function gave nothing.
    #[error(
        "its entry function refuses this host (ABI {RUMBO_ABI_MAJOR}.{RUMBO_ABI_MINOR}); it asks for a newer one, or \
         it failed to start"
    )]
    Refused,
    /// Not a record of ours.
    #[error(
        "its entry function returned a record that begins with {found:#018x}, expected {RUMBO_MAGIC:#018x}; it is \
         no Rumbo plugin"
    )]
    Magic {
        /// The first eight bytes.
        found: u64,
    },
    /// Another ABI.
    #[error(
        "it speaks ABI {found_major}.{found_minor}, this host speaks ABI {RUMBO_ABI_MAJOR} (up to \
         {RUMBO_ABI_MAJOR}.{RUMBO_ABI_MINOR}); rebuild the plugin against this version, or take the version of Rumbo \
         that it was built for"
    )]
    Major {
        /// Major that the library was built with.
        found_major: u32,
        /// Minor that the library was built with.
        found_minor: u32,
    },
    /// A record that is too small to be one.
    #[error(
        "its record says to have {found} bytes, expected at least {least}; it is damaged or built by hand wrongly"
    )]
    Size {
        /// Bytes that it says.
        found: usize,
        /// Bytes that every version has.
        least: usize,
    },
    /// A panic in it would end the program.
    #[error(
        "it does not catch its panics: it was built with `panic = \"abort\"` (or without RUMBO_CATCHES), so that a \
         fault in it would end the whole program with the robot moving; build it with `panic = \"unwind\"`"
    )]
    Aborts,
    /// The number of entries is wrong.
    #[error("its record says {says} entries, but its list has {has}; it is damaged or built by hand wrongly")]
    Count {
        /// Entries by the record.
        says: usize,
        /// Entries in the list, where that could be told.
        has: String,
    },
    /// One entry is wrong.
    #[error("its entry {index} {problem}")]
    Entry {
        /// Which, counted from 0, and its name where it has one.
        index: String,
        /// What is wrong.
        problem: String,
    },
}

/// What a library says about itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ModuleInfo {
    /// ABI that it was built with.
    pub abi: (u32, u32),
    /// Compiler and versions.
    pub build_info: String,
}

/// Bytes of a module record in ABI 1.0; what is appended later must be read behind a look at `size`.
const SMALLEST_MODULE: usize = offset_of!(rumbo_module, entries) + size_of::<*const *const rumbo_entry>();
const _: () = assert!(SMALLEST_MODULE == size_of::<rumbo_module>());

/// Entries of one library at most.
const MOST_ENTRIES: usize = 1024;
/// Bytes of a text in a record at most.
const LONGEST_TEXT: usize = 16 << 20;

/// An entry whose parts are there.
#[derive(Debug, Clone)]
pub(super) struct Record {
    /// Where the library keeps it.
    pub at: *const rumbo_entry,
    /// A copy.
    pub entry: rumbo_entry,
    /// The seat that it fills.
    pub stage: Stage,
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// What it is.
    pub summary: String,
    /// Schema of its parameters.
    pub schema: serde_json::Value,
    /// Parameters at their defaults.
    pub defaults: toml::Table,
}

// SAFETY: a record lives as long as its library, which is never unloaded, and is never written.
unsafe impl Send for Record {}
// SAFETY: as above.
unsafe impl Sync for Record {}

/// Reads a module record and its entries.
///
/// # Safety
/// `module` is what the entry function of a library returned.
pub(super) unsafe fn records(module: *const rumbo_module) -> Result<(ModuleInfo, Vec<Record>), ModuleError> {
    // SAFETY: for all blocks below: the library vouches for what lies behind its record; each part is read only after
    // what says that it is there.
    if module.is_null() || !module.is_aligned() {
        return Err(ModuleError::Refused);
    }
    let magic = unsafe { (*module).magic };
    if magic != RUMBO_MAGIC {
        return Err(ModuleError::Magic { found: magic });
    }
    let (found, least) = unsafe { ((*module).size, SMALLEST_MODULE) };
    if found < least {
        return Err(ModuleError::Size { found, least });
    }
    let module = unsafe { module.read() };
    if module.abi_major != RUMBO_ABI_MAJOR {
        let (found_major, found_minor) = (module.abi_major, module.abi_minor);
        return Err(ModuleError::Major { found_major, found_minor });
    }
    if module.flags & RUMBO_CATCHES == 0 {
        return Err(ModuleError::Aborts);
    }
    let pointers = unsafe { entry_pointers(&module)? };
    let mut records = Vec::with_capacity(pointers.len());
    for (index, at) in pointers.into_iter().enumerate() {
        let entry = unsafe { read(at) };
        let record = entry.ok_or_else(|| "points nowhere".to_owned()).and_then(|entry| {
            let name = unsafe { text(entry.name, "name")? };
            unsafe { record(at, &entry, name.clone()) }.map_err(|problem| format!("(`{name}`) {problem}"))
        });
        records.push(record.map_err(|problem| ModuleError::Entry { index: index.to_string(), problem })?);
    }
    let build_info = unsafe { string_from(module.build_info) };
    Ok((ModuleInfo { abi: (module.abi_major, module.abi_minor), build_info }, records))
}

/// The list of entries; its end is marked, so that a wrong count is seen on both sides.
///
/// # Safety
/// The list is as long as its null pointer at the end says.
unsafe fn entry_pointers(module: &rumbo_module) -> Result<Vec<*const rumbo_entry>, ModuleError> {
    let says = module.n_entries;
    let wrong = |has: String| ModuleError::Count { says, has };
    if says > MOST_ENTRIES {
        return Err(wrong(format!("room for at most {MOST_ENTRIES}")));
    }
    if module.entries.is_null() || !module.entries.is_aligned() {
        return Err(wrong("no place".to_owned()));
    }
    let mut pointers = Vec::new();
    for index in 0..=says {
        // SAFETY: the list has a null pointer behind the last entry; none was met yet.
        let pointer = unsafe { module.entries.add(index).read() };
        match (pointer.is_null(), index == says) {
            (true, true) => break,
            (true, false) => return Err(wrong(index.to_string())),
            (false, true) => return Err(wrong("more".to_owned())),
            (false, false) => pointers.push(pointer),
        }
    }
    Ok(pointers)
}

/// # Safety
/// As [`records`]: the library vouches for what its record points to.
unsafe fn text(view: rumbo_str, what: &str) -> Result<String, String> {
    if view.len > LONGEST_TEXT {
        return Err(format!("has a {what} of {} bytes, expected at most {LONGEST_TEXT}", view.len));
    }
    // SAFETY: the library vouches for its texts.
    let text = unsafe { str_from(view) };
    text.map(str::to_owned).ok_or_else(|| format!("has a {what} that is no UTF-8 text"))
}

unsafe fn record(at: *const rumbo_entry, entry: &rumbo_entry, name: String) -> Result<Record, String> {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if name.is_empty() || name.len() > 64 || !name.chars().all(good) {
        return Err("has a bad name, expected 1 to 64 of a-z, 0-9 and _".to_owned());
    }
    let stage = match entry.stage {
        RUMBO_SENSOR => Stage::Sensor,
        RUMBO_MAP_BUILDER => Stage::MapBuilder,
        RUMBO_LOCALIZER => Stage::Localizer,
        RUMBO_SLAM => Stage::Slam,
        RUMBO_PLANNER => Stage::Planner,
        RUMBO_AVOIDER => Stage::Avoider,
        other => {
            return Err(format!("is for a stage with the number {other}, which this host does not know"));
        }
    };
    if entry.create.is_none() {
        return Err("has no function `create`".to_owned());
    }
    // SAFETY: the stage says which table lies there.
    if let Some(missing) = unsafe { missing_function(stage, entry) } {
        return Err(missing);
    }
    // SAFETY: for the four texts: the library vouches for them.
    let (version, summary) = unsafe { (text(entry.version, "version")?, text(entry.summary, "summary")?) };
    let (schema, defaults) =
        unsafe { (text(entry.schema_json, "schema")?, text(entry.defaults_toml, "text of defaults")?) };
    let schema = match schema.is_empty() {
        true => serde_json::json!({ "type": "object", "properties": {}, "additionalProperties": false }),
        false => serde_json::from_str(&schema).map_err(|e| format!("has a schema that is no JSON: {e}"))?,
    };
    if !schema.is_object() {
        let expected = r#"expected { "type": "object", "properties": ... }"#;
        return Err(format!("has a schema that is no JSON object, {expected}"));
    }
    let defaults = match defaults.is_empty() {
        true => super::config::defaults_of(&schema),
        false => toml::from_str(&defaults)
            .map_err(|e| format!("has defaults that are no TOML: {}", e.message()))?,
    };
    Ok(Record { at, entry: *entry, stage, name, version, summary, schema, defaults })
}

/// What the table of this stage must have and has not.
///
/// # Safety
/// `entry.table` is null or points to the table of `stage`.
unsafe fn missing_function(stage: Stage, entry: &rumbo_entry) -> Option<String> {
    macro_rules! need {
        ($table:ty: $($function:ident),*) => {{
            // SAFETY: as promised by the caller.
            match unsafe { read(entry.table.cast::<$table>()) } {
                None => Some("has no table of functions: `table` points nowhere".to_owned()),
                Some(table) => {
                    let functions = [$((stringify!($function), table.$function.is_some())),*];
                    let missing = functions.into_iter().find(|(_, is_there)| !is_there);
                    missing.map(|(name, _)| format!("has no function `{name}` in its table"))
                }
            }
        }};
    }
    match stage {
        Stage::Planner => need!(rumbo_planner_table: destroy, plan),
        Stage::Avoider => need!(rumbo_avoider_table: destroy, steer),
        Stage::Localizer => need!(rumbo_localizer_table: destroy, start, update),
        Stage::MapBuilder => need!(rumbo_map_builder_table: destroy, start, insert),
        Stage::Slam => need!(rumbo_slam_table: destroy, start, update),
        Stage::Sensor => need!(rumbo_sensor_table: destroy, poll),
        Stage::World => Some("is a world, and worlds do not cross yet".to_owned()),
    }
}
