//! Which scans become part of the map, and how.

use super::tracker::ScanTracker;
use rumbo_core::frames::Pose2;
use rumbo_core::map::{GridFault, Map};
use rumbo_core::messages::{LaserScan, Observation};
use rumbo_kit::occupancy::{Inserted, UpdateGate};
use rumbo_kit::scan_match::MatchStatus;

impl ScanTracker {
    /// What did not match becomes part of the map only where the map ends, and not far from where it matched last.
    pub(super) fn may_insert(&self) -> bool {
        match self.status {
            MatchStatus::Ok | MatchStatus::Degenerate => true,
            MatchStatus::LowOverlap => self.way_without_match_m <= self.settings.explore_grace_m,
            MatchStatus::TooFewPoints | MatchStatus::Diverged => false,
        }
    }

    pub(super) fn insert(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        map_from_base: &Pose2,
        map: &mut Map,
    ) -> Result<bool, GridFault> {
        let field_of_view_rad = scan.bearing_step_rad.abs() * scan.ranges_m.len() as f64;
        let [way_m, turn_rad] = self.settings.insert_every;
        let known = self.gates.iter().position(|(sensor, _)| *sensor == observation.sensor);
        let idx = known.unwrap_or_else(|| {
            self.gates.push((observation.sensor, UpdateGate::new(way_m, turn_rad)));
            self.gates.len() - 1
        });
        let Some((_, gate)) = self.gates.get_mut(idx) else { return Ok(false) };
        if !gate.is_open(map_from_base, field_of_view_rad) {
            return Ok(false);
        }
        let inserted = self.mapper.insert(scan, map_from_base, &observation.base_from_sensor, map)?;
        if matches!(inserted, Inserted::Empty | Inserted::Beside) {
            return Ok(false);
        }
        gate.close(map_from_base);
        self.mapper.insert(scan, map_from_base, &observation.base_from_sensor, &mut self.kept)?;
        self.counters.inserted += 1;
        map.touch();
        Ok(true)
    }
}
