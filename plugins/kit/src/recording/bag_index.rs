//! What the end of an MCAP file says of the rest, so that viewers find a moment without reading all of it.

use super::layout::Layout;
use super::mcap_records::{Records, TopicRecord};
use mcap::records::op;

/// What the end of the file says of the rest.
#[derive(Debug, Default)]
pub struct Index {
    /// Bytes of the file so far.
    pub at: u64,
    /// Topics, in the order of their numbers from 0.
    pub topics: Vec<TopicRecord>,
    /// Schemas, in the order of their numbers from 1.
    pub schemas: Vec<Layout>,
    /// Where the pieces are.
    pub pieces: Records,
    /// How many there are.
    pub n_pieces: usize,
    times: Option<(u64, u64)>,
}

impl Index {
    /// Counts a message; how many its topic had before.
    pub fn count(&mut self, topic: u16, log_time: u64) -> u64 {
        let (first, last) = self.times.unwrap_or((log_time, log_time));
        self.times = Some((first.min(log_time), last.max(log_time)));
        let Some(topic) = self.topics.get_mut(usize::from(topic)) else { return 0 };
        topic.n_messages += 1;
        topic.n_messages - 1
    }

    /// The end of the data, the summary and the foot of the file.
    pub fn end(&self) -> Vec<u8> {
        let mut end = Records::default();
        // A sum of all the data would be one more pass over it; every piece has its own.
        end.record(op::DATA_END, |end| end.u32(0));
        let (summary, mut groups) = (end.bytes.len(), Vec::new());
        let mut group = |end: &mut Records, opcode: u8, fill: &dyn Fn(&mut Records)| {
            let start = end.bytes.len();
            fill(end);
            groups.push((opcode, start, end.bytes.len() - start));
        };
        group(&mut end, op::SCHEMA, &|end| {
            (1..).zip(&self.schemas).for_each(|(id, layout)| end.schema(id, layout));
        });
        group(&mut end, op::CHANNEL, &|end| {
            (0..).zip(&self.topics).for_each(|(id, topic)| end.channel(id, topic));
        });
        group(&mut end, op::STATISTICS, &|end| self.statistics(end));
        group(&mut end, op::CHUNK_INDEX, &|end| end.bytes.extend_from_slice(&self.pieces.bytes));
        let offsets = end.bytes.len();
        for (opcode, start, len) in groups.into_iter().filter(|(_, _, len)| *len > 0) {
            end.record(op::SUMMARY_OFFSET, |end| {
                end.put([opcode]);
                [self.at + start as u64, len as u64].into_iter().for_each(|number| end.u64(number));
            });
        }
        end.put([op::FOOTER]);
        [20, self.at + summary as u64, self.at + offsets as u64]
            .into_iter()
            .for_each(|number| end.u64(number));
        let sum = crc32fast::hash(end.bytes.get(summary..).unwrap_or_default());
        end.put(sum.to_le_bytes());
        end.bytes.extend_from_slice(super::MAGIC);
        end.bytes
    }

    fn statistics(&self, end: &mut Records) {
        end.record(op::STATISTICS, |end| {
            let (first, last) = self.times.unwrap_or_default();
            end.u64(self.topics.iter().map(|topic| topic.n_messages).sum());
            end.u16(u16::try_from(self.schemas.len()).unwrap_or(u16::MAX));
            [self.topics.len(), 0, 0, self.n_pieces].into_iter().for_each(|number| end.u32(number));
            [first, last].into_iter().for_each(|number| end.u64(number));
            end.u32(self.topics.len() * 10);
            for (id, topic) in (0..).zip(&self.topics) {
                end.u16(id);
                end.u64(topic.n_messages);
            }
        });
    }
}
