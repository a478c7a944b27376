//! Writes an MCAP file: nothing packed, no clock, closed pieces that stay readable when the rest is lost.

use super::layout::Layout;
use mcap::records::MessageHeader;
use mcap::{McapError, McapResult, WriteOptions, Writer};
use rumbo_core::time::{Span, Time};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

/// A topic that was opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TopicId(u16);

/// A bag that grows.
pub struct BagWriter<W: Write + Seek = BufWriter<File>> {
    writer: Writer<W>,
    closed_at: Option<Time>,
    n_messages: u32,
}

impl BagWriter {
    /// Begins a file, over one that is there.
    pub fn create(path: &Path) -> McapResult<BagWriter> {
        BagWriter::new(BufWriter::new(File::create(path)?))
    }
}

impl<W: Write + Seek> BagWriter<W> {
    /// A piece is closed when it has so many bytes.
    const MOST_BYTES: u64 = 1 << 20;
    /// A piece is closed when it is so old: no more is lost when the power goes.
    const LONGEST: Span = Span(2_000_000_000);

    /// Begins a bag.
    pub fn new(to: W) -> McapResult<BagWriter<W>> {
        let options = WriteOptions::new()
            // Packing would cost processor time in the run; `mcap compress` does it afterwards.
            .compression(None)
            .profile("ros2")
            .library(concat!("rumbo ", env!("CARGO_PKG_VERSION")))
            .chunk_size(Some(Self::MOST_BYTES))
            // A piece is written at once with its length in front, so a cut leaves no length that lies.
            .disable_seeking(true)
            .calculate_data_section_crc(false);
        Ok(BagWriter { writer: options.create(to)?, closed_at: None, n_messages: 0 })
    }

    /// Opens a topic.
    pub fn topic(&mut self, name: &str, layout: &Layout) -> McapResult<TopicId> {
        let schema = self.writer.add_schema(layout.name, "ros2msg", layout.text.as_bytes())?;
        self.writer.add_channel(schema, name, "cdr", &BTreeMap::new()).map(TopicId)
    }

    /// Writes a message.
    pub fn write(&mut self, topic: TopicId, now: Time, message: &[u8]) -> McapResult<()> {
        let log_time = u64::try_from(now.0).unwrap_or(0);
        let header = MessageHeader {
            channel_id: topic.0,
            sequence: self.n_messages,
            log_time,
            publish_time: log_time,
        };
        self.n_messages = self.n_messages.wrapping_add(1);
        self.writer.write_to_known_channel(&header, message)
    }

    /// Between two steps: closes the piece if it is old enough.
    pub fn rest(&mut self, now: Time) -> McapResult<()> {
        let closed_at = *self.closed_at.get_or_insert(now);
        if now - closed_at >= Self::LONGEST {
            self.closed_at = Some(now);
            self.writer.flush()?;
        }
        Ok(())
    }

    /// Closes the file and gives back what it was written to.
    pub fn finish(mut self) -> McapResult<W> {
        self.writer.finish()?;
        let mut to = self.writer.into_inner();
        to.flush().map_err(McapError::from)?;
        Ok(to)
    }
}
