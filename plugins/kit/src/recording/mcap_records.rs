//! The records that MCAP files are made of (<https://mcap.dev/spec>).

use super::layout::Layout;
use mcap::records::op;

/// Opcode and length.
pub const RECORD: usize = 1 + 8;

/// Records, one after the other.
#[derive(Debug, Default)]
pub struct Records {
    /// As they stand in the file.
    pub bytes: Vec<u8>,
}

impl Records {
    /// Bytes.
    pub fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes.extend_from_slice(&bytes);
    }

    /// A number.
    pub fn u16(&mut self, value: u16) {
        self.put(value.to_le_bytes());
    }

    /// A length or count.
    pub fn u32(&mut self, value: usize) {
        self.put(u32::try_from(value).unwrap_or(u32::MAX).to_le_bytes());
    }

    /// A number.
    pub fn u64(&mut self, value: u64) {
        self.put(value.to_le_bytes());
    }

    /// A text behind its length.
    pub fn text(&mut self, text: &str) {
        self.u32(text.len());
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// Fills in what was left open.
    pub fn set(&mut self, at: usize, bytes: &[u8]) {
        if let Some(room) = self.bytes.get_mut(at..at + bytes.len()) {
            room.copy_from_slice(bytes);
        }
    }

    /// A record; its length is filled in when `fields` are there.
    pub fn record(&mut self, opcode: u8, fields: impl FnOnce(&mut Records)) {
        let start = self.bytes.len();
        self.put([opcode]);
        self.u64(0);
        fields(self);
        let len = (self.bytes.len() - start - RECORD) as u64;
        self.set(start + 1, &len.to_le_bytes());
    }

    /// What messages of a schema look like.
    pub fn schema(&mut self, id: u16, layout: &Layout) {
        self.record(op::SCHEMA, |records| {
            records.u16(id);
            [layout.name, "ros2msg", layout.text].into_iter().for_each(|text| records.text(text));
        });
    }

    /// A topic and its schema.
    pub fn channel(&mut self, id: u16, topic: &TopicRecord) {
        self.record(op::CHANNEL, |records| {
            records.u16(id);
            records.u16(topic.schema);
            [topic.name.as_str(), "cdr"].into_iter().for_each(|text| records.text(text));
            records.u32(0);
        });
    }
}

/// A topic of the file.
#[derive(Debug, Clone)]
pub struct TopicRecord {
    /// Its name.
    pub name: String,
    /// What its messages are.
    pub layout: Layout,
    /// The number of that.
    pub schema: u16,
    /// Messages so far.
    pub n_messages: u64,
}

impl TopicRecord {
    /// The same name and messages.
    pub fn is(&self, name: &str, layout: &Layout) -> bool {
        self.name == name && self.layout == *layout
    }
}
