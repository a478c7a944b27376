//! What makes a drive hard beyond slip: raised floor, a body that sways, hands that carry the robot away, wheels that spin
//! in place.

use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::params::Start;

/// How the robot's wheels take ramps and steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Wheels {
    /// Radius of a wheel, meters: round wheels soften edges.
    pub radius_m: f64,
    /// The robot climbs steps up to this high, meters, at most the wheels' radius. It stops at a higher one as at a wall,
    /// from above as well.
    pub max_step_m: f64,
    /// The robot climbs ramps up to this steep, degrees. The edges of a steeper one are walls to it.
    pub max_slope_deg: f64,
}

impl Default for Wheels {
    fn default() -> Self {
        Self { radius_m: 0.20, max_step_m: 0.15, max_slope_deg: 45.0 }
    }
}

impl Wheels {
    pub(super) fn faults(&self) -> Vec<BuildError> {
        let Self { radius_m, max_step_m, max_slope_deg } = *self;
        let mut faults = Vec::new();
        if !(radius_m.is_finite() && radius_m > 0.0) {
            faults
                .push(BuildError::at("wheels.radius_m", format!("is {radius_m}, expected a length above 0")));
        } else if !(0.0..=radius_m).contains(&max_step_m) {
            let expected = format!("is {max_step_m}, expected 0 up to the wheels' radius of {radius_m}");
            faults.push(BuildError::at("wheels.max_step_m", expected));
        }
        if !(0.0..=STEEPEST_DEG).contains(&max_slope_deg) {
            let expected = format!("is {max_slope_deg}, expected 0 to {STEEPEST_DEG} degrees");
            faults.push(BuildError::at("wheels.max_slope_deg", expected));
        }
        faults
    }
}

/// Nobody drives on anything steeper.
const STEEPEST_DEG: f64 = 75.0;
/// A sway grows and dies away in so long, seconds.
const EASE_S: f64 = 1.0;

/// A body that rolls and pitches on its wheels, as a test of what levels sensors. The roll is a sine, the pitch a quarter
/// of a period ahead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sway {
    /// Largest roll, degrees.
    pub roll_deg: f64,
    /// Largest pitch, degrees; positive looks down.
    pub pitch_deg: f64,
    /// Periods a second; 0 is a body that leans all the time.
    pub frequency_hz: f64,
    /// When it begins, seconds. It grows to its size within one second.
    pub from_s: f64,
    /// When it is over, seconds; it dies away in the second before. Absent: never.
    pub to_s: Option<f64>,
}

impl Default for Sway {
    fn default() -> Self {
        Self { roll_deg: 0.0, pitch_deg: 0.0, frequency_hz: 0.5, from_s: 0.0, to_s: None }
    }
}

impl Sway {
    /// Roll and pitch at a time, radians.
    pub fn at(&self, time_s: f64) -> (f64, f64) {
        let ease = |seconds: f64| {
            let share = (seconds / EASE_S).clamp(0.0, 1.0);
            share * share * (3.0 - 2.0 * share)
        };
        let size = ease(time_s - self.from_s) * self.to_s.map_or(1.0, |to_s| ease(to_s - time_s));
        let (sin, cos) = if self.frequency_hz > 0.0 {
            (std::f64::consts::TAU * self.frequency_hz * time_s).sin_cos()
        } else {
            (1.0, 1.0)
        };
        (size * sin * self.roll_deg.to_radians(), size * cos * self.pitch_deg.to_radians())
    }

    pub(super) fn faults(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        for (key, value) in [("roll_deg", self.roll_deg), ("pitch_deg", self.pitch_deg)] {
            if !(-STEEPEST_DEG..=STEEPEST_DEG).contains(&value) {
                let expected = format!("is {value}, expected {} to {STEEPEST_DEG} degrees", -STEEPEST_DEG);
                faults.push(BuildError::at(format!("sway.{key}"), expected));
            }
        }
        for (key, value) in [("frequency_hz", self.frequency_hz), ("from_s", self.from_s)] {
            if !(value.is_finite() && value >= 0.0) {
                let message = format!("is {value}, expected a finite number, 0 or more");
                faults.push(BuildError::at(format!("sway.{key}"), message));
            }
        }
        faults.extend(end_fault("sway.to_s", self.from_s, self.to_s));
        faults
    }
}

/// Somebody carries the robot away: from one moment to the next it stands elsewhere, and no wheel has turned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kidnap {
    /// When, seconds.
    pub at_s: f64,
    /// Where to: `{ x_m, y_m, yaw_deg }` in the map.
    pub to: Start,
}

impl Kidnap {
    pub(super) fn faults(&self) -> Vec<BuildError> {
        let mut faults = self.to.faults("kidnap.to");
        if !(self.at_s.is_finite() && self.at_s >= 0.0) {
            let message = format!("is {}, expected a finite time, 0 or more", self.at_s);
            faults.push(BuildError::at("kidnap.at_s", message));
        }
        faults
    }
}

/// When or where wheels spin in place: they turn, and the robot stays.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Spin {
    /// From this time on, seconds.
    pub from_s: f64,
    /// Until this time, seconds; absent: for ever.
    pub to_s: Option<f64>,
    /// Only while the base is over this area, `[left, bottom, right, top]` in meters of the map; absent: everywhere.
    pub area: Option<[f64; 4]>,
}

impl Spin {
    /// Whether wheels spin at a time and place.
    pub fn holds(&self, time_s: f64, x_m: f64, y_m: f64) -> bool {
        let is_there = self.area.is_none_or(|[left, bottom, right, top]| {
            (left..=right).contains(&x_m) && (bottom..=top).contains(&y_m)
        });
        is_there && time_s >= self.from_s && self.to_s.is_none_or(|to_s| time_s < to_s)
    }

    pub(super) fn faults(&self, idx: usize) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if !(self.from_s.is_finite() && self.from_s >= 0.0) {
            let message = format!("is {}, expected a finite time, 0 or more", self.from_s);
            faults.push(BuildError::at(format!("spins[{idx}].from_s"), message));
        }
        faults.extend(end_fault(&format!("spins[{idx}].to_s"), self.from_s, self.to_s));
        if let Some(area) = self.area {
            let [left, bottom, right, top] = area;
            if !(area.iter().all(|bound| bound.is_finite()) && left < right && bottom < top) {
                let message = format!("is {area:?}, expected [left, bottom, right, top]");
                faults.push(BuildError::at(format!("spins[{idx}].area"), message));
            }
        }
        faults
    }
}

fn end_fault(key: &str, from_s: f64, to_s: Option<f64>) -> Option<BuildError> {
    let to_s = to_s.filter(|to_s| !(to_s.is_finite() && *to_s > from_s))?;
    Some(BuildError::at(key, format!("is {to_s}, expected a finite time after from_s = {from_s}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sway_grows_swings_and_dies_away() {
        let sway = Sway { roll_deg: 20.0, pitch_deg: 10.0, frequency_hz: 0.5, from_s: 2.0, to_s: Some(10.0) };
        let deg = |time_s: f64| {
            let (roll_rad, pitch_rad) = sway.at(time_s);
            (roll_rad.to_degrees(), pitch_rad.to_degrees())
        };
        assert_eq!(deg(1.9), (0.0, 0.0));
        assert_eq!(deg(10.0), (0.0, 0.0));
        let (roll, pitch) = deg(4.5);
        assert!((roll - 20.0).abs() < 1e-9 && pitch.abs() < 1e-9, "a quarter of a period: {roll} {pitch}");
        let (roll, pitch) = deg(5.0);
        assert!(roll.abs() < 1e-9 && (pitch + 10.0).abs() < 1e-9, "half of a period: {roll} {pitch}");
        assert!((deg(2.5).0.abs() - 10.0).abs() < 1e-9, "half of its size after half a second");
        let lean = Sway { pitch_deg: 45.0, frequency_hz: 0.0, ..Sway::default() };
        assert!((lean.at(7.3).1.to_degrees() - 45.0).abs() < 1e-9);
    }

    #[test]
    fn wheels_spin_when_and_where_they_are_told_to() {
        let spin = Spin { from_s: 3.0, to_s: Some(5.0), area: Some([0.0, 0.0, 1.0, 2.0]) };
        assert!(spin.holds(3.0, 0.5, 0.5) && spin.holds(4.9, 1.0, 2.0));
        assert!(!spin.holds(2.9, 0.5, 0.5) && !spin.holds(5.0, 0.5, 0.5) && !spin.holds(4.0, 1.1, 0.5));
        assert!(Spin::default().holds(1e6, -50.0, 50.0));
    }

    #[test]
    fn impossible_hardships_are_all_told() {
        let paths = |faults: Vec<BuildError>| faults.into_iter().map(|fault| fault.path).collect::<Vec<_>>();
        let wheels = Wheels { radius_m: 0.1, max_step_m: 0.2, max_slope_deg: 90.0 };
        assert_eq!(paths(wheels.faults()), ["wheels.max_step_m", "wheels.max_slope_deg"]);
        assert_eq!(paths(Wheels { radius_m: 0.0, ..wheels }.faults())[0], "wheels.radius_m");
        let sway =
            Sway { roll_deg: 80.0, pitch_deg: f64::NAN, frequency_hz: -1.0, from_s: 4.0, to_s: Some(4.0) };
        let keys = ["sway.roll_deg", "sway.pitch_deg", "sway.frequency_hz", "sway.to_s"];
        assert_eq!(paths(sway.faults()), keys);
        let to = Start { x_m: f64::NAN, ..Start::default() };
        assert_eq!(paths(Kidnap { at_s: -1.0, to }.faults()), ["kidnap.to.x_m", "kidnap.at_s"]);
        let spin = Spin { from_s: -1.0, to_s: Some(f64::NAN), area: Some([1.0, 0.0, 0.0, 1.0]) };
        assert_eq!(paths(spin.faults(2)), ["spins[2].from_s", "spins[2].to_s", "spins[2].area"]);
        for fine in [Wheels::default().faults(), Sway::default().faults(), Spin::default().faults(0)] {
            assert!(fine.is_empty(), "{fine:?}");
        }
    }
}
