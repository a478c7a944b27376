//! Writes an MCAP file: nothing packed, no clock, closed pieces that stay readable when the rest is lost.
//!
//! The records are put together here and not by the crate `mcap`: its writer looks every message up in several maps and
//! sums it byte by byte, which took more of the processor than all the rest of a recording. The crate still reads, and
//! proves in the tests that what is written here is what it expects.

use super::bag_index::Index;
use super::bag_piece::Piece;
use super::cdr_writer::CdrWriter;
use super::layout::Layout;
use super::mcap_records::{Records, TopicRecord};
use mcap::records::op;
use rumbo_core::time::{Span, Time};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// A topic that was opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TopicId(u16);

/// A bag that grows.
#[derive(Debug)]
pub struct BagWriter<W: Write = File> {
    /// None when the file is closed, or when writing failed.
    to: Option<W>,
    piece: Piece,
    index: Index,
    closed_at: Option<Time>,
    longest: Span,
}

impl BagWriter {
    /// Begins a file, over one that is there.
    pub fn create(path: &Path) -> io::Result<BagWriter> {
        BagWriter::new(File::create(path)?)
    }
}

impl<W: Write> BagWriter<W> {
    /// A piece is closed when it has so many bytes.
    const MOST_BYTES: usize = 1 << 20;
    /// A piece is closed when it is so old: no more is lost when the power goes.
    const LONGEST: Span = Span(2_000_000_000);

    /// Begins a bag.
    pub fn new(mut to: W) -> io::Result<BagWriter<W>> {
        let mut first = Records::default();
        first.bytes.extend_from_slice(super::MAGIC);
        first.record(op::HEADER, |records| {
            records.text("ros2");
            records.text(concat!("rumbo ", env!("CARGO_PKG_VERSION")));
        });
        to.write_all(&first.bytes)?;
        let mut bag = BagWriter {
            to: Some(to),
            // A little more: the message that fills a piece stands in it whole, and the indexes behind it.
            piece: Piece::with_capacity(Self::MOST_BYTES + (1 << 16)),
            index: Index::default(),
            closed_at: None,
            longest: Self::LONGEST,
        };
        bag.index.at = first.bytes.len() as u64;
        Ok(bag)
    }

    /// Closes pieces after another time than two seconds.
    pub fn close_after(mut self, longest: Span) -> BagWriter<W> {
        self.longest = longest;
        self
    }

    /// Opens a topic; one that is open already is the same.
    pub fn topic(&mut self, name: &str, layout: &Layout) -> io::Result<TopicId> {
        if let Some(known) = self.index.topics.iter().position(|known| known.is(name, layout)) {
            return Ok(TopicId(number(known)?));
        }
        let schemas = &mut self.index.schemas;
        let known = schemas.iter().position(|known| known == layout);
        let schema = number(known.unwrap_or(schemas.len()))?.saturating_add(1);
        let mut records = Records::default();
        if known.is_none() {
            schemas.push(*layout);
            records.schema(schema, layout);
        }
        let topic = TopicRecord { name: name.to_owned(), layout: *layout, schema, n_messages: 0 };
        let id = number(self.index.topics.len())?;
        records.channel(id, &topic);
        self.piece.records(&records);
        self.index.topics.push(topic);
        self.piece.open();
        Ok(TopicId(id))
    }

    /// Writes a message.
    pub fn write(&mut self, topic: TopicId, now: Time, message: &[u8]) -> io::Result<()> {
        self.write_with(topic, now, |cdr| cdr.room().extend(message))
    }

    /// Writes the message that `put` writes, where it stays; none where it writes nothing.
    pub fn write_with(
        &mut self,
        topic: TopicId,
        now: Time,
        put: impl FnOnce(&mut CdrWriter),
    ) -> io::Result<()> {
        let (log_time, index) = (u64::try_from(now.0).unwrap_or(0), &mut self.index);
        self.piece.message(topic.0, log_time, || index.count(topic.0, log_time), put);
        if self.piece.len() >= Self::MOST_BYTES { self.close_piece() } else { Ok(()) }
    }

    /// Between two steps: closes the piece if it is old enough.
    pub fn rest(&mut self, now: Time) -> io::Result<()> {
        let closed_at = *self.closed_at.get_or_insert(now);
        if now - closed_at >= self.longest {
            self.closed_at = Some(now);
            self.close_piece()?;
        }
        Ok(())
    }

    /// A piece is written at once with its length in front, so a cut leaves no length that lies.
    fn close_piece(&mut self) -> io::Result<()> {
        if self.piece.len() == 0 {
            return Ok(());
        }
        let mut to = self.to.take().ok_or_else(Self::failed)?;
        to.write_all(self.piece.close(&mut self.index))?;
        self.piece.clear();
        self.to = Some(to);
        Ok(())
    }

    /// Closes the file and gives back what it was written to.
    pub fn finish(mut self) -> io::Result<W> {
        self.close_piece()?;
        let mut to = self.to.take().ok_or_else(Self::failed)?;
        to.write_all(&self.index.end())?;
        to.flush()?;
        Ok(to)
    }

    fn failed() -> io::Error {
        io::Error::other("writing failed before")
    }
}

/// Whoever forgets to finish a bag, or cannot since something panicked, loses nothing.
impl<W: Write> Drop for BagWriter<W> {
    fn drop(&mut self) {
        let closed = if self.to.is_some() { self.close_piece() } else { Ok(()) };
        if let (Ok(()), Some(to)) = (closed, &mut self.to) {
            let _ = to.write_all(&self.index.end());
        }
    }
}

/// MCAP numbers topics and schemas with 16 bits.
fn number(idx: usize) -> io::Result<u16> {
    u16::try_from(idx).map_err(|_| io::Error::other("more than 65,535 topics or schemas"))
}
