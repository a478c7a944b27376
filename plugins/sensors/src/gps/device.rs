//! What a real receiver says, as positions in the map.

use rumbo_core::messages::PositionFix;

use super::local_frame::LocalFrame;
use super::nmea::{Decoder, Fix, Gga, Heard, Tally};
use super::reception::ReceptionModel;
use crate::text_device::TextDecoder;

/// Standard deviation of a height that the receiver does not say, meters.
const UNKNOWN_HEIGHT_M: f64 = 1000.0;

/// How fixes become positions. The first fix is the origin where none is configured.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Interpretation {
    pub error_m: f64,
    pub rotation_rad: f64,
    pub frame: Option<LocalFrame>,
    pub altitude_m: Option<f64>,
}

impl Interpretation {
    /// The position of the antenna in the map.
    pub fn position(&mut self, fix: &Fix) -> PositionFix {
        let Fix { latitude_deg, longitude_deg, altitude_m, .. } = *fix;
        let here = || LocalFrame::new(latitude_deg, longitude_deg, self.rotation_rad);
        let frame = *self.frame.get_or_insert_with(here);
        let map_m = frame.map_m(latitude_deg, longitude_deg);
        let ground_m = self.altitude_m.or(altitude_m);
        self.altitude_m = ground_m;
        let height_m = altitude_m.zip(ground_m).map(|(altitude_m, ground_m)| altitude_m - ground_m);
        let deviation_m = ReceptionModel::deviation_m(self.error_m);
        let height_deviation_m = if height_m.is_some() { deviation_m } else { UNKNOWN_HEIGHT_M };
        PositionFix {
            position_m: [map_m.x, map_m.y, height_m.unwrap_or(0.0)],
            deviation_m: [deviation_m, deviation_m, height_deviation_m],
        }
    }
}

/// GGA sentences of a stream; the others are counted.
#[derive(Debug, Default)]
pub(super) struct Receiver {
    decoder: Decoder,
    last_refusal: Option<String>,
}

impl TextDecoder for Receiver {
    type Reading = Gga;
    type Tally = Tally;

    fn push(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
    }

    fn break_off(&mut self) {
        self.decoder.break_off();
    }

    fn next(&mut self) -> Option<Gga> {
        loop {
            match self.decoder.next()? {
                Heard::Gga(gga) => return Some(gga),
                Heard::Other => {}
                Heard::Refused(refusal) => self.last_refusal = Some(refusal.to_string()),
            }
        }
    }

    fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    fn instead(&self) -> String {
        let Tally { n_others, .. } = self.tally();
        let refusal = self.last_refusal.as_deref();
        match (n_others, refusal) {
            (0, None) => "no line of it has ended".to_owned(),
            (0, Some(refusal)) => format!("the last line was refused ({refusal})"),
            (n_others, _) => format!("{n_others} sentences of other kinds, and no GGA"),
        }
    }
}
