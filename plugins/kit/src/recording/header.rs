//! What a recording says of itself: first what was run, last how it ended.

use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::layout::SCHEMA;
use super::outputs::place2;
use super::pose::numbers2;
use rumbo_core::frames::Pose2;
use rumbo_core::time::Time;
use std::path::PathBuf;

/// What was run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RunHeader {
    /// Name and version of the program.
    pub program: String,
    /// The pipeline's file, as it was named.
    pub file: String,
    /// The effective pipeline; its seed is in it.
    pub pipeline: String,
    /// Stage, name and version of every plugin.
    pub plugins: Vec<String>,
    /// Names of the sensors, in the order of their numbers.
    pub sensors: Vec<String>,
    /// `--duration` of the command line, seconds.
    pub duration_s: Option<f64>,
    /// When the run began.
    pub started: Time,
    /// The world played a recording: sensors were due at its stamps.
    pub is_recording: bool,
    /// Time passed by itself: background work arrived when it was ready.
    pub is_real_time: bool,
    /// Where the world said that the robot stands at the start.
    pub start: Option<Pose2>,
    /// The map that belongs to the world.
    pub map_file: Option<PathBuf>,
    /// Tells whether that file is still the same.
    pub map_file_hash: u64,
    /// The recording that the world played.
    pub recording_file: Option<PathBuf>,
}

/// Why a header cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HeaderError {
    /// It comes from a later program.
    #[error("the recording has schema {found}, this program reads up to {SCHEMA}; use a newer rumbo")]
    Schema {
        /// What it says.
        found: u32,
    },
    /// It is broken.
    #[error("the recording does not say what was run: {0}")]
    Cdr(#[from] CdrError),
}

/// Writes what was run.
pub fn put_header(cdr: &mut CdrWriter, header: &RunHeader) {
    cdr.begin().u32(SCHEMA);
    for text in [&header.program, &header.file, &header.pipeline] {
        cdr.text(text);
    }
    for texts in [&header.plugins, &header.sensors] {
        cdr.length(texts.len());
        texts.iter().for_each(|text| cdr.text(text));
    }
    cdr.f64s(header.duration_s.as_slice());
    cdr.i64(header.started.0);
    cdr.bool(header.is_recording);
    cdr.bool(header.is_real_time);
    cdr.f64s(header.start.as_ref().map(numbers2).as_ref().map_or(&[], |start| start));
    cdr.text(&shown(header.map_file.as_ref()));
    cdr.u64(header.map_file_hash);
    cdr.text(&shown(header.recording_file.as_ref()));
}

/// Reads what was run.
pub fn read_header(message: &[u8]) -> Result<RunHeader, HeaderError> {
    let mut cdr = CdrReader::new(message)?;
    let found = cdr.u32()?;
    if found == 0 || found > SCHEMA {
        return Err(HeaderError::Schema { found });
    }
    let texts = |cdr: &mut CdrReader<'_>| (0..cdr.length(4)?).map(|_| cdr.text()).collect::<Result<_, _>>();
    let path = |text: String| (!text.is_empty()).then(|| PathBuf::from(text));
    Ok(RunHeader {
        program: cdr.text()?,
        file: cdr.text()?,
        pipeline: cdr.text()?,
        plugins: texts(&mut cdr)?,
        sensors: texts(&mut cdr)?,
        duration_s: cdr.f64s()?.first().copied(),
        started: Time(cdr.i64()?),
        is_recording: cdr.bool()?,
        is_real_time: cdr.bool()?,
        start: place2(&cdr.f64s()?),
        map_file: path(cdr.text()?),
        map_file_hash: cdr.u64()?,
        recording_file: path(cdr.text()?),
    })
}

fn shown(path: Option<&PathBuf>) -> String {
    path.map(|path| path.display().to_string()).unwrap_or_default()
}

/// Writes how the run ended.
pub fn put_end(cdr: &mut CdrWriter, reason: &str, detail: &str) {
    cdr.begin().text(reason);
    cdr.text(detail);
}

/// How the run ended: a word, and more for people.
pub fn read_end(message: &[u8]) -> Result<(String, String), CdrError> {
    let mut cdr = CdrReader::new(message)?;
    Ok((cdr.text()?, cdr.text()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;

    #[test]
    fn a_header_comes_back_and_a_later_one_is_refused() {
        let header = RunHeader {
            plugins: vec!["planner dp 0.1.0".into()],
            duration_s: Some(0.1),
            start: Some(pose2(1.0 / 3.0, 0.0, 0.1)),
            map_file: Some("a.yaml".into()),
            map_file_hash: u64::MAX,
            ..RunHeader::default()
        };
        let mut cdr = CdrWriter::default();
        put_header(&mut cdr, &header);
        assert_eq!(read_header(cdr.bytes()), Ok(header));
        let mut later = cdr.bytes().to_vec();
        later[4] = 99;
        assert_eq!(read_header(&later), Err(HeaderError::Schema { found: 99 }));
        assert!(read_header(&later[..3]).is_err());
    }
}
