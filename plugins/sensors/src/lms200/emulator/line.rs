//! The wire from the device: every byte takes its time.

use std::collections::VecDeque;

use rumbo_core::time::Time;

use super::Faults;
use crate::lms200::protocol::LineSpeed;

/// A byte that arrives at another speed than it was sent.
pub(super) fn garbled(byte: u8) -> u8 {
    byte.rotate_left(3) ^ 0x5A
}

#[derive(Debug)]
struct OnItsWay {
    /// When it is through.
    at: Time,
    byte: u8,
    speed: LineSpeed,
    is_first: bool,
    /// The last byte of a scan that was not damaged so far.
    ends_whole_scan: bool,
}

#[derive(Debug, Default)]
pub(super) struct Line {
    bytes: VecDeque<OnItsWay>,
    free_at: Time,
    /// All bytes of the telegram that is arriving came through.
    is_clean: bool,
    n_whole_scans: u64,
    n_sent_scans: u64,
}

impl Line {
    pub fn free_at(&self) -> Time {
        self.free_at
    }

    pub fn n_whole_scans(&self) -> u64 {
        self.n_whole_scans
    }

    pub fn n_sent_scans(&self) -> u64 {
        self.n_sent_scans
    }

    /// Sends a telegram as soon as the line is free.
    pub fn send(&mut self, now: Time, speed: LineSpeed, telegram: &[u8], is_scan: bool, faults: &mut Faults) {
        let starts_at = self.free_at.max(now) + faults.delay;
        self.free_at = starts_at + speed.time_of(telegram.len());
        let (mut is_whole, mut is_first) = (true, true);
        for (idx, &sent) in telegram.iter().enumerate() {
            let arrives = faults.befall(sent);
            is_whole &= arrives == Some(sent);
            if let Some(byte) = arrives {
                let at = starts_at + speed.time_of(idx + 1);
                self.bytes.push_back(OnItsWay { at, byte, speed, is_first, ends_whole_scan: false });
                is_first = false;
            }
        }
        self.n_sent_scans += u64::from(is_scan);
        if let Some(last) = self.bytes.back_mut() {
            last.ends_whole_scan = is_scan && is_whole;
        }
    }

    /// Bytes that are through by now.
    pub fn take(&mut self, now: Time, speed: LineSpeed, is_unplugged: bool, out: &mut Vec<u8>) {
        while let Some(next) = self.bytes.pop_front_if(|next| next.at <= now) {
            self.is_clean |= next.is_first;
            if is_unplugged {
                self.is_clean = false;
                continue;
            }
            if next.speed == speed {
                out.push(next.byte);
            } else {
                self.is_clean = false;
                out.push(garbled(next.byte));
            }
            self.n_whole_scans += u64::from(next.ends_whole_scan && self.is_clean);
        }
    }

    /// The telegram that is arriving will not be whole.
    pub fn break_off(&mut self) {
        self.is_clean = false;
    }

    /// Nothing is on its way any more.
    pub fn clear(&mut self, now: Time) {
        self.bytes.clear();
        self.free_at = now;
    }
}
