//! What a library declares: its module record, its entries, and what an instance is built from.

use super::basic::rumbo_error;
use super::basic::{rumbo_point, rumbo_pose3, rumbo_str};
use super::host::rumbo_host;
use super::inputs::rumbo_bytes_out;
use std::ffi::c_void;

/// First bytes of every module record: "RUMBOPLG".
pub const RUMBO_MAGIC: u64 = 0x474c_504f_424d_5552;
/// Major of this ABI: changes when an old plugin can no longer be loaded.
pub const RUMBO_ABI_MAJOR: u32 = 1;
/// Minor of this ABI: goes up when something is appended.
pub const RUMBO_ABI_MINOR: u32 = 1;
/// Flag of a module: panics and exceptions are caught inside. A library without it is refused.
pub const RUMBO_CATCHES: u64 = 1;

/// Stage of an entry: `rumbo_sensor_table`.
pub const RUMBO_SENSOR: u32 = 1;
/// Stage of an entry: `rumbo_map_builder_table`.
pub const RUMBO_MAP_BUILDER: u32 = 2;
/// Stage of an entry: `rumbo_localizer_table`.
pub const RUMBO_LOCALIZER: u32 = 3;
/// Stage of an entry: `rumbo_slam_table`.
pub const RUMBO_SLAM: u32 = 4;
/// Stage of an entry: `rumbo_planner_table`.
pub const RUMBO_PLANNER: u32 = 5;
/// Stage of an entry: `rumbo_avoider_table`.
pub const RUMBO_AVOIDER: u32 = 6;

/// Bit of a map layer: occupancy of cells.
pub const RUMBO_LAYER_GRID: u32 = 1;
/// Bit of a map layer: wall lines.
pub const RUMBO_LAYER_LINES: u32 = 2;
/// Bit of a map layer: points that can be recognized.
pub const RUMBO_LAYER_LANDMARKS: u32 = 4;
/// Bit of a map layer: occupancy in space.
pub const RUMBO_LAYER_VOXELS: u32 = 8;

/// Drive with two driven wheels; bit 0 of `drives`.
pub const RUMBO_DIFFERENTIAL: u32 = 0;
/// Drive with one steered wheel; bit 1 of `drives`.
pub const RUMBO_TRICYCLE: u32 = 1;
/// Drive that moves every way; bit 2 of `drives`.
pub const RUMBO_OMNIDIRECTIONAL: u32 = 2;

/// The record that the entry function returns; it lives as long as the library.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_module {
    /// `RUMBO_MAGIC`.
    pub magic: u64,
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_ABI_MAJOR` of the header that the plugin was built with.
    pub abi_major: u32,
    /// `RUMBO_ABI_MINOR` of that header.
    pub abi_minor: u32,
    /// `RUMBO_CATCHES`, ...
    pub flags: u64,
    /// Compiler and versions: told, never compared.
    pub build_info: rumbo_str,
    /// Number of entries.
    pub n_entries: usize,
    /// The entries, with a null pointer behind the last.
    pub entries: *const *const rumbo_entry,
}

/// One plugin of a library.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_entry {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_PLANNER`, ...
    pub stage: u32,
    /// 0.
    pub reserved: u32,
    /// Its name in a pipeline: lower case letters, digits and `_`.
    pub name: rumbo_str,
    /// Its version.
    pub version: rumbo_str,
    /// What it is, in one line.
    pub summary: rumbo_str,
    /// JSON schema of its parameters (draft 2020-12), with their defaults, limits and descriptions; empty for none.
    pub schema_json: rumbo_str,
    /// All parameters at their defaults as TOML; where it is empty the schema's `default`s count.
    pub defaults_toml: rumbo_str,
    /// For the library's own use.
    pub user: *const c_void,
    /// Functions of the stage: `rumbo_planner_table`, ...
    pub table: *const c_void,
    /// Makes an instance; may be called from any thread.
    pub create: Option<
        unsafe extern "C" fn(
            entry: *const rumbo_entry,
            host: *const rumbo_host,
            config: *const rumbo_config,
            context: *const rumbo_context,
            instance: *mut *mut c_void,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Says what it needs and gives with these parameters; null where that is nothing.
    pub manifest: Option<
        unsafe extern "C" fn(
            entry: *const rumbo_entry,
            config: *const rumbo_config,
            manifest: *mut rumbo_manifest,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Reads the parameters: `RUMBO_BAD_CONFIG` where they cannot be understood, else `RUMBO_OK` and every impossible
    /// value into `faults`. Null where the schema says it all.
    pub check: Option<
        unsafe extern "C" fn(
            entry: *const rumbo_entry,
            config: *const rumbo_config,
            faults: *mut rumbo_fault_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
    /// Writes all parameters, defaults included, as TOML. Null where the schema's `default`s say it all.
    pub parameters: Option<
        unsafe extern "C" fn(
            entry: *const rumbo_entry,
            config: *const rumbo_config,
            text: *mut rumbo_bytes_out,
            error: *mut rumbo_error,
        ) -> i32,
    >,
}

/// The parameters that a pipeline gives, parsed by the host.
#[repr(C)]
pub struct rumbo_values {
    _private: [u8; 0],
}

/// The parameters of one plugin: as text, and through `config_...` of the host table.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_config {
    /// Bytes of this struct.
    pub size: usize,
    /// The plugin's own keys as a TOML document.
    pub toml: rumbo_str,
    /// The same with the defaults, for the accessors.
    pub values: *const rumbo_values,
}

/// Takes faults of parameters.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_fault_out {
    /// Bytes of this struct.
    pub size: usize,
    /// For `push`.
    pub ctx: *mut c_void,
    /// Adds a fault: the key (`weights[2]`; empty for the whole section), what is wrong, what to do (may be empty).
    pub push:
        Option<unsafe extern "C" fn(ctx: *mut c_void, path: rumbo_str, message: rumbo_str, help: rumbo_str)>,
}

/// Groups of observation kinds at most in a manifest.
pub const RUMBO_MOST_CONSUMED: usize = 8;

/// What a plugin needs and gives. The host hands it over with nothing needed and every drive steered.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_manifest {
    /// Bytes of this struct.
    pub size: usize,
    /// Layers that it reads: `RUMBO_LAYER_GRID | ...`.
    pub needs_layers: u32,
    /// Layers that it writes.
    pub gives_layers: u32,
    /// Kinds that it makes: bit `RUMBO_LASER_SCAN`, ...
    pub produces: u32,
    /// Drives that it can steer or plan for: bit `RUMBO_DIFFERENTIAL`, ...
    pub drives: u32,
    /// How many of `consumes` are used.
    pub n_consumes: u32,
    /// Kinds that it cannot do without: of each group at least one.
    pub consumes: [u32; RUMBO_MOST_CONSUMED],
    /// It writes on top of layers that another builder gives.
    pub overlays: u8,
    /// It derives its observations from other sensors'.
    pub is_virtual: u8,
    /// It cannot find a robot whose pose nobody names.
    pub needs_start_pose: u8,
    /// It asks for motion while it looks for the robot.
    pub wishes_motion: u8,
    /// How often it runs when the pipeline does not say, Hz; not-a-number for no wish.
    pub default_rate_hz: f64,
    /// The fastest that it can do, Hz; not-a-number for no limit.
    pub max_rate_hz: f64,
    /// Kinds that it takes where some sensor makes them, and does without where none does (since 1.1).
    pub uses: u32,
    /// 0.
    pub reserved: u32,
    /// How wide a range sensor sees to its sides, radians in all; not-a-number of what has no such view (since 1.1).
    pub field_of_view_rad: f64,
}

/// The robot.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_robot {
    /// Bytes of this struct.
    pub size: usize,
    /// `RUMBO_DIFFERENTIAL`, ...
    pub drive: u32,
    /// 1 where the guard watches the stop zone.
    pub guard_stop_zone: u32,
    /// Distance between the wheels, meters (differential, tricycle).
    pub track_m: f64,
    /// Tricycle: from the fixed axle to the steered wheel, meters.
    pub wheelbase_m: f64,
    /// Tricycle: largest steering angle, degrees.
    pub max_steer_deg: f64,
    /// Tricycle: largest steering rate, deg/s.
    pub max_steer_rate_deg_s: f64,
    /// Radius of a round hull, meters.
    pub radius_m: f64,
    /// Corners of the hull; 0 for a round one.
    pub n_corners: usize,
    /// The corners in the base frame, meters.
    pub corners: *const rumbo_point,
    /// Height, meters.
    pub height_m: f64,
    /// Top speed, m/s.
    pub max_speed_m_s: f64,
    /// Top turning rate, deg/s.
    pub max_turn_deg_s: f64,
    /// Top acceleration, m/s².
    pub max_accel_m_s2: f64,
    /// Top turning acceleration, deg/s².
    pub max_turn_accel_deg_s2: f64,
    /// Deceleration when stopping, m/s².
    pub braking_m_s2: f64,
    /// The guard's distance from obstacles, meters.
    pub guard_margin_m: f64,
    /// The guard's reaction time, seconds.
    pub guard_latency_s: f64,
    /// Age at which data are stale, seconds.
    pub guard_stale_after_s: f64,
    /// Tricycle: 1 where the steered wheel is behind the axle (since 1.1).
    pub is_steered_behind: u32,
    /// 0.
    pub reserved: u32,
}

/// A flag that long work looks at: `give_up_is_raised`; `give_up_retain` and `give_up_release` to keep it.
#[repr(C)]
pub struct rumbo_give_up {
    _private: [u8; 0],
}

/// A random stream of one instance, for `random_...` of the host table; lives as long as the instance.
#[repr(C)]
pub struct rumbo_rng {
    _private: [u8; 0],
}

/// What an instance may know when it is made.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_context {
    /// Bytes of this struct.
    pub size: usize,
    /// Name of the instance: the sensor's, else the section's.
    pub name: rumbo_str,
    /// Which sensor this is, in the order of the file; 0 for other stages.
    pub sensor: u16,
    /// 1 for a check only: touch no device and start no thread.
    pub dry_run: u8,
    /// 1 where slow work runs on threads of its own: time passes by itself.
    pub is_threaded: u8,
    /// Layers that some stage of the pipeline needs: `RUMBO_LAYER_GRID | ...`.
    pub wanted_layers: u32,
    /// The robot.
    pub robot: *const rumbo_robot,
    /// Where a sensor sits.
    pub base_from_sensor: rumbo_pose3,
    /// How often the stage will run, Hz; not-a-number where the engine decides.
    pub rate_hz: f64,
    /// Seed of the run.
    pub seed: u64,
    /// This instance's random stream.
    pub rng: *mut rumbo_rng,
    /// Folder that relative paths start from.
    pub folder: rumbo_str,
    /// The map that belongs to the world; empty for none.
    pub world_map: rumbo_str,
    /// The recording that the world plays; empty for none.
    pub world_recording: rumbo_str,
    /// Time that inline background work takes, nanoseconds.
    pub latency_ns: i64,
    /// Raised when all work shall stop; lives as long as the instance.
    pub abort: *const rumbo_give_up,
}

/// Type of the only symbol that a library exports, `rumbo_plugin_entry_v1`; null says that it cannot work with this
/// host. Only the record behind the answer is read before it is checked.
pub type rumbo_plugin_entry = Option<unsafe extern "C" fn(host: *const rumbo_host) -> *const rumbo_module>;

/// Name of the entry symbol, with its zero.
pub const RUMBO_ENTRY: &[u8; 22] = b"rumbo_plugin_entry_v1\0";
