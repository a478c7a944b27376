//! A world that answers as no world should.

use rumbo_core::frames::Twist;
use rumbo_core::messages::{Command, Marks};
use rumbo_core::stages::{Advance, Answer, Attitude, Drove, Probe, WheelMotion, World, WorldError};
use rumbo_core::time::Time;

/// What it answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Odd {
    /// It has nothing.
    Unsupported,
    /// It is damaged.
    Fails,
    /// Read your own device.
    Live,
    /// A position, whatever was asked.
    Position,
    /// Ranges, whatever was asked.
    Ranges,
    /// What was asked for, but nothing in it.
    Empty,
    /// What was asked for, with this number everywhere.
    Number(f32),
    /// A recording of nothing.
    NothingRecorded,
}

impl Odd {
    /// All of them, with names for reports.
    pub const ALL: [(&'static str, Odd); 12] = [
        ("a world that has nothing", Odd::Unsupported),
        ("a world that fails", Odd::Fails),
        ("a world without a device", Odd::Live),
        ("a world that always answers a position", Odd::Position),
        ("a world that always answers ranges", Odd::Ranges),
        ("empty answers", Odd::Empty),
        ("answers of NaN", Odd::Number(f32::NAN)),
        ("infinite answers", Odd::Number(f32::INFINITY)),
        ("negative answers", Odd::Number(-1.0)),
        ("zero answers", Odd::Number(0.0)),
        ("answers of 1e30", Odd::Number(1e30)),
        ("an empty recording", Odd::NothingRecorded),
    ];
}

/// See [`Odd`].
#[derive(Debug)]
pub struct OddWorld {
    odd: Odd,
    now: Time,
    ranges: Vec<f32>,
    contacts: Vec<f64>,
    marks: Marks,
}

impl OddWorld {
    /// A world that answers like this.
    pub fn new(odd: Odd) -> OddWorld {
        OddWorld { odd, now: Time::ZERO, ranges: Vec::new(), contacts: Vec::new(), marks: Marks::default() }
    }

    fn ranges(&mut self, n: usize, value: f32) -> Answer<'_> {
        self.ranges.clear();
        // No sensor has more pixels than this.
        self.ranges.resize(n.min(1 << 24), value);
        Answer::Ranges(&self.ranges)
    }

    fn filled(&mut self, probe: &Probe<'_>, value: f32, n: impl Fn(usize) -> usize) -> Answer<'_> {
        let number = f64::from(value);
        match probe {
            Probe::Beams { n_beams, .. } => self.ranges(n(*n_beams), value),
            Probe::Cones { bearings_rad, .. } => self.ranges(n(bearings_rad.len()), value),
            Probe::Depth { intrinsics, .. } => {
                self.ranges(n(intrinsics.width as usize * intrinsics.height as usize), value)
            }
            Probe::Wheels => Answer::Wheels(WheelMotion {
                rolled_m: [number; 4],
                n_wheels: n(2) as u32,
                turned_rad: number,
                steering_rad: number,
                twist: Twist::new(number, number),
            }),
            Probe::Attitude => Answer::Attitude(Attitude {
                attitude_rad: [number; 3],
                rates_rad_s: [number; 3],
                accelerations_m_s2: [number; 3],
            }),
            Probe::Position | Probe::Person { .. } => Answer::Position([number; 3]),
            Probe::Contacts => {
                self.contacts = vec![number; n(2)];
                Answer::Contacts(&self.contacts)
            }
            Probe::Marks { .. } => Answer::Marks(&self.marks),
            _ => Answer::Recorded(&[]),
        }
    }
}

impl World for OddWorld {
    fn now(&self) -> Time {
        self.now
    }

    fn advance(&mut self, to: Time) -> Result<Advance, WorldError> {
        self.now = to;
        Ok(Advance::Reached(to))
    }

    fn drive(&mut self, _: &Command) -> Result<Drove, WorldError> {
        Ok(Drove::Drove)
    }

    fn probe<'w>(&'w mut self, probe: &Probe<'_>) -> Result<Answer<'w>, WorldError> {
        match self.odd {
            Odd::Unsupported => Err(WorldError::Unsupported { probe: probe.name() }),
            Odd::Fails => Err(WorldError::Other("it is out of order".into())),
            Odd::Live => Ok(Answer::Live),
            Odd::Position => Ok(Answer::Position([1.0, 2.0, 3.0])),
            Odd::Ranges => Ok(self.ranges(7, 1.0)),
            Odd::Empty => Ok(self.filled(probe, 0.0, |_| 0)),
            Odd::Number(value) => Ok(self.filled(probe, value, |n| n)),
            Odd::NothingRecorded => Ok(Answer::Recorded(&[])),
        }
    }
}
