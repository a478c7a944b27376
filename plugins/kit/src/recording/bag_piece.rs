//! The piece of an MCAP file that grows until it is written.

use super::bag_index::Index;
use super::mcap_records::{RECORD, Records};
use mcap::records::op;

/// Bytes in front of the records of a piece: opcode, length, first and last time, size, sum, no packing, size.
pub const HEAD: usize = 1 + 8 + 8 + 8 + 8 + 4 + 4 + 8;

/// A piece of the file that is not yet written.
#[derive(Debug)]
pub struct Piece {
    /// Room for the head, then schemas, channels and messages.
    pub records: Records,
    /// Times and places of messages, one list a topic.
    pub places: Vec<Vec<(u64, u64)>>,
    times: Option<(u64, u64)>,
}

impl Piece {
    /// An empty piece with room for so many bytes.
    pub fn with_capacity(n_bytes: usize) -> Piece {
        let mut bytes = Vec::with_capacity(HEAD + n_bytes);
        bytes.resize(HEAD, 0);
        Piece { records: Records { bytes }, places: Vec::new(), times: None }
    }

    /// Makes room for one more topic: so much that the list of a usual piece never has to move.
    pub fn open(&mut self) {
        const USUAL: usize = 256;
        self.places.push(Vec::with_capacity(USUAL));
    }

    /// There is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.records.bytes.len() <= HEAD
    }

    /// A message. Its head is put together first and copied at once: most messages are not much longer.
    pub fn message(&mut self, topic: u16, number: u64, log_time: u64, message: &[u8]) {
        const FIELDS: usize = 2 + 4 + 8 + 8;
        let bytes = &mut self.records.bytes;
        if let Some(places) = self.places.get_mut(usize::from(topic)) {
            places.push((log_time, (bytes.len() - HEAD) as u64));
        }
        let (first, last) = self.times.unwrap_or((log_time, log_time));
        self.times = Some((first.min(log_time), last.max(log_time)));
        let mut head = [0; RECORD + FIELDS];
        head[0] = op::MESSAGE;
        head[1..9].copy_from_slice(&((FIELDS + message.len()) as u64).to_le_bytes());
        head[9..11].copy_from_slice(&topic.to_le_bytes());
        // The sequence of messages may wrap around.
        head[11..15].copy_from_slice(&(number as u32).to_le_bytes());
        head[15..23].copy_from_slice(&log_time.to_le_bytes());
        head[23..31].copy_from_slice(&log_time.to_le_bytes());
        bytes.extend_from_slice(&head);
        bytes.extend_from_slice(message);
    }

    /// The bytes of the piece with the indexes of its topics behind it.
    pub fn close(&mut self, index: &mut Index) -> &[u8] {
        let records = &mut self.records;
        let (first, last) = self.times.unwrap_or_default();
        let len = (records.bytes.len() - HEAD) as u64;
        let sum = crc32fast::hash(records.bytes.get(HEAD..).unwrap_or_default());
        let mut head = Records { bytes: Vec::with_capacity(HEAD) };
        head.put([op::CHUNK]);
        [(HEAD - RECORD) as u64 + len, first, last, len].into_iter().for_each(|number| head.u64(number));
        head.put(sum.to_le_bytes());
        head.text("");
        head.u64(len);
        records.set(0, &head.bytes);
        let piece_len = records.bytes.len();
        let mut offsets = Records::default();
        for (topic, places) in (0..).zip(&self.places).filter(|(_, places)| !places.is_empty()) {
            offsets.u16(topic);
            offsets.u64(index.at + records.bytes.len() as u64);
            records.record(op::MESSAGE_INDEX, |records| {
                records.u16(topic);
                records.u32(places.len() * 16);
                places.iter().flat_map(|(time, at)| [*time, *at]).for_each(|number| records.u64(number));
            });
        }
        index.pieces.record(op::CHUNK_INDEX, |entry| {
            [first, last, index.at, piece_len as u64].into_iter().for_each(|number| entry.u64(number));
            entry.u32(offsets.bytes.len());
            entry.bytes.extend_from_slice(&offsets.bytes);
            entry.u64((records.bytes.len() - piece_len) as u64);
            entry.text("");
            [len, len].into_iter().for_each(|number| entry.u64(number));
        });
        index.n_pieces += 1;
        index.at += records.bytes.len() as u64;
        &records.bytes
    }

    /// Empties it; its room is kept.
    pub fn clear(&mut self) {
        self.records.bytes.truncate(HEAD);
        self.places.iter_mut().for_each(Vec::clear);
        self.times = None;
    }
}
