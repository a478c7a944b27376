//! MCAP files as a stream of messages: from front to back, without the index at the end, so that a file that was cut off
//! is read up to the cut. Memory holds one record at a time.

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use rumbo_core::time::Time;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// What an MCAP file begins with.
pub const MAGIC: &[u8] = mcap::MAGIC;

/// A topic of a bag and what its messages are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagChannel {
    /// Its name.
    pub topic: String,
    /// Name of the schema, `sensor_msgs/msg/LaserScan`; empty where there is none.
    pub schema: String,
    /// How messages are encoded, `cdr`.
    pub encoding: String,
}

/// One message of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BagMessage {
    /// Where it was said.
    pub channel: Arc<BagChannel>,
    /// When it was written down, since 1970 or since the start of a simulation.
    pub log_time: Time,
    /// What was said.
    pub data: Vec<u8>,
}

/// How the file ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BagEnd {
    /// As it should.
    Whole,
    /// In the middle.
    Cut,
    /// It cannot be read further.
    Damaged(String),
}

/// Why a bag cannot be opened.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BagError {
    /// There is no such file, or it must not be read.
    #[error("{path}: cannot read the recording: {reason}")]
    Io {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// It is something else.
    #[error("{path}: this is no MCAP file: it begins with {found}, expected the MCAP magic bytes")]
    NoBag {
        /// The file.
        path: String,
        /// Its first bytes.
        found: String,
    },
}

/// A bag on its way.
pub struct BagReader {
    name: String,
    file: Box<dyn Read + Send>,
    reader: LinearReader,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Arc<BagChannel>>,
    end: Option<BagEnd>,
    is_closed: bool,
}

impl std::fmt::Debug for BagReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BagReader({})", self.name)
    }
}

impl BagReader {
    /// No record of a robot is larger; what claims to be is damage.
    const MOST_BYTES: usize = 1 << 28;
    /// Read from the file at once.
    const AT_ONCE: usize = 1 << 16;

    /// Opens a bag.
    pub fn open(path: &Path) -> Result<BagReader, BagError> {
        let name = path.display().to_string();
        match File::open(path) {
            Ok(file) => BagReader::new(Box::new(BufReader::with_capacity(Self::AT_ONCE, file)), name),
            Err(error) => Err(BagError::Io { path: name, reason: error.to_string() }),
        }
    }

    /// A bag from anywhere; `name` stands in what is said of it.
    pub fn new(mut file: Box<dyn Read + Send>, name: String) -> Result<BagReader, BagError> {
        let mut first = Vec::new();
        if let Err(error) = (&mut file).take(MAGIC.len() as u64).read_to_end(&mut first) {
            return Err(BagError::Io { path: name, reason: error.to_string() });
        }
        if first != MAGIC {
            let found = if first.is_empty() { "nothing".to_owned() } else { format!("{first:02x?}") };
            return Err(BagError::NoBag { path: name, found });
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(Self::MOST_BYTES);
        Ok(BagReader {
            name,
            file,
            reader: LinearReader::new_with_options(options),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            end: None,
            is_closed: false,
        })
    }

    /// The name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How the file ended; none before that.
    pub fn end(&self) -> Option<&BagEnd> {
        self.end.as_ref()
    }

    fn read_on(&mut self) -> Result<Option<BagMessage>, BagEnd> {
        while let Some(event) = self.reader.next_event() {
            let (opcode, data) = match event.map_err(|error| end_of(&error, self.is_closed))? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let room = self.reader.insert(wanted.clamp(1, Self::AT_ONCE));
                    let n_read = self.file.read(room).map_err(|error| BagEnd::Damaged(error.to_string()))?;
                    self.reader.notify_read(n_read);
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => (opcode, data),
            };
            match opcode {
                op::SCHEMA | op::CHANNEL | op::MESSAGE => {}
                op::DATA_END => {
                    self.is_closed = true;
                    continue;
                }
                _ => continue,
            }
            let record = mcap::parse_record(opcode, data).map_err(|error| end_of(&error, self.is_closed))?;
            match record {
                Record::Schema { header, .. } => {
                    self.schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    let (topic, encoding) = (channel.topic, channel.message_encoding);
                    self.channels.insert(channel.id, Arc::new(BagChannel { topic, schema, encoding }));
                }
                Record::Message { header, data } => {
                    let unknown = || {
                        BagEnd::Damaged(format!(
                            "a message of channel {}, which is not there",
                            header.channel_id
                        ))
                    };
                    let channel = self.channels.get(&header.channel_id).ok_or_else(unknown)?.clone();
                    let log_time = Time(i64::try_from(header.log_time).unwrap_or(i64::MAX));
                    return Ok(Some(BagMessage { channel, log_time, data: data.into_owned() }));
                }
                _ => {}
            }
        }
        Ok(None)
    }
}

impl Iterator for BagReader {
    type Item = BagMessage;

    fn next(&mut self) -> Option<BagMessage> {
        if self.end.is_some() {
            return None;
        }
        match self.read_on() {
            Ok(Some(message)) => return Some(message),
            Ok(None) => self.end = Some(BagEnd::Whole),
            Err(end) => self.end = Some(end),
        }
        None
    }
}

fn end_of(error: &McapError, is_closed: bool) -> BagEnd {
    match error {
        // All messages stand before the end of the data; what follows only helps to find them.
        _ if is_closed => BagEnd::Whole,
        McapError::UnexpectedEof | McapError::UnexpectedEoc => BagEnd::Cut,
        other => BagEnd::Damaged(other.to_string()),
    }
}
