//! The piece of an MCAP file that grows until it is written.

use super::bag_index::Index;
use super::cdr_writer::CdrWriter;
use super::mcap_records::{RECORD, Records};
use super::room::Room;
use mcap::records::op;

/// Bytes in front of the records of a piece: opcode, length, first and last time, size, sum, no packing, size.
pub const HEAD: usize = 1 + 8 + 8 + 8 + 8 + 4 + 4 + 8;
/// Bytes in front of a message: those of a record, topic, number, and two times.
const MESSAGE_HEAD: usize = RECORD + 2 + 4 + 8 + 8;

/// A piece of the file that is not yet written. Messages are written where they stand in the file: nothing of it is copied
/// before the system takes it.
#[derive(Debug)]
pub struct Piece {
    /// Room for the head, then schemas, channels and messages.
    cdr: CdrWriter,
    /// Times and places of messages, one list a topic. The spec calls them optional, but readers that go by the index see
    /// no messages without them (<https://github.com/foxglove/mcap/issues/1735>, pull request 1179).
    places: Vec<Vec<(u64, u64)>>,
    times: Option<(u64, u64)>,
}

impl Piece {
    /// An empty piece with room for so many bytes.
    pub fn with_capacity(n_bytes: usize) -> Piece {
        let mut room = Room::with_capacity(HEAD + n_bytes);
        room.put([0; HEAD]);
        Piece { cdr: CdrWriter::in_room(room), places: Vec::new(), times: None }
    }

    /// Makes room for one more topic: so much that the list of a usual piece never has to move.
    pub fn open(&mut self) {
        const USUAL: usize = 256;
        self.places.push(Vec::with_capacity(USUAL));
    }

    /// Bytes of its records.
    pub fn len(&self) -> usize {
        self.cdr.written().len() - HEAD
    }

    /// Records that are no messages.
    pub fn records(&mut self, records: &Records) {
        self.cdr.room().extend(&records.bytes);
    }

    /// A message that `put` writes, the `number`th of its topic; none where it writes nothing.
    pub fn message(
        &mut self,
        topic: u16,
        log_time: u64,
        number: impl FnOnce() -> u64,
        put: impl FnOnce(&mut CdrWriter),
    ) {
        let start = self.cdr.written().len();
        self.cdr.room().next(MESSAGE_HEAD);
        self.cdr.go_on();
        put(&mut self.cdr);
        let len = self.cdr.bytes().len();
        if len == 0 {
            self.cdr.room().cut(start);
            return;
        }
        if let Some(places) = self.places.get_mut(usize::from(topic)) {
            places.push((log_time, (start - HEAD) as u64));
        }
        let (first, last) = self.times.unwrap_or((log_time, log_time));
        self.times = Some((first.min(log_time), last.max(log_time)));
        let mut head = [0; MESSAGE_HEAD];
        head[0] = op::MESSAGE;
        head[1..9].copy_from_slice(&((MESSAGE_HEAD - RECORD + len) as u64).to_le_bytes());
        head[9..11].copy_from_slice(&topic.to_le_bytes());
        // The sequence of messages may wrap around.
        head[11..15].copy_from_slice(&(number() as u32).to_le_bytes());
        head[15..23].copy_from_slice(&log_time.to_le_bytes());
        head[23..31].copy_from_slice(&log_time.to_le_bytes());
        self.cdr.room().set(start, &head);
    }

    /// The bytes of the piece with the indexes of its topics behind it.
    pub fn close(&mut self, index: &mut Index) -> &[u8] {
        let room = self.cdr.room();
        let (first, last) = self.times.unwrap_or_default();
        let piece_len = room.len();
        let len = (piece_len - HEAD) as u64;
        let sum = crc32fast::hash(room.bytes().get(HEAD..).unwrap_or_default());
        let mut head = Records { bytes: Vec::with_capacity(HEAD) };
        head.put([op::CHUNK]);
        [(HEAD - RECORD) as u64 + len, first, last, len].into_iter().for_each(|number| head.u64(number));
        head.put(sum.to_le_bytes());
        head.text("");
        head.u64(len);
        room.set(0, &head.bytes);
        let mut offsets = Records::default();
        for (topic, places) in (0..).zip(&self.places).filter(|(_, places)| !places.is_empty()) {
            offsets.u16(topic);
            offsets.u64(index.at + room.len() as u64);
            room.put([op::MESSAGE_INDEX]);
            room.put((2 + 4 + places.len() as u64 * 16).to_le_bytes());
            room.put(topic.to_le_bytes());
            room.put(u32::try_from(places.len() * 16).unwrap_or(u32::MAX).to_le_bytes());
            places.iter().for_each(|(time, at)| {
                room.put(time.to_le_bytes());
                room.put(at.to_le_bytes());
            });
        }
        index.pieces.record(op::CHUNK_INDEX, |entry| {
            [first, last, index.at, piece_len as u64].into_iter().for_each(|number| entry.u64(number));
            entry.u32(offsets.bytes.len());
            entry.bytes.extend_from_slice(&offsets.bytes);
            entry.u64((room.len() - piece_len) as u64);
            entry.text("");
            [len, len].into_iter().for_each(|number| entry.u64(number));
        });
        index.n_pieces += 1;
        index.at += room.len() as u64;
        room.bytes()
    }

    /// Empties it; its room is kept.
    pub fn clear(&mut self) {
        self.cdr.room().cut(HEAD);
        self.places.iter_mut().for_each(Vec::clear);
        self.times = None;
    }
}
