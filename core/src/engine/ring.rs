//! The observations of the last moments, and who has seen what.

use crate::messages::{Data, Observation, ObservationKind, Observations, Seen, SensorId};
use std::collections::VecDeque;

/// How far one stage has read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Cursor(u64);

/// Which observations a stage gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter<'a> {
    /// Everything but what the odometer seat hides and what virtual sensors replace.
    Public,
    /// Everything that virtual sensors do not replace, raw odometry included: for the odometer seat itself.
    Raw,
    /// Only these sensors': for a virtual sensor.
    Of(&'a [SensorId]),
}

/// A bounded ring of observations in the order of their arrival.
#[derive(Debug)]
pub struct Ring {
    items: VecDeque<Observation>,
    capacity: usize,
    first: u64,
    has_odometer: bool,
    replaced: Vec<(SensorId, ObservationKind)>,
    order: Vec<u32>,
}

impl Ring {
    /// A ring of this many observations; with an odometer seat, other odometry is hidden from all but that seat.
    pub fn new(capacity: usize, has_odometer: bool) -> Ring {
        let (items, order) = (VecDeque::with_capacity(capacity + 1), Vec::with_capacity(capacity));
        Ring { items, capacity, first: 0, has_odometer, replaced: Vec::new(), order }
    }

    /// The same; what these sensors say of these kinds is for virtual sensors only, which say it better.
    pub fn replacing(self, replaced: Vec<(SensorId, ObservationKind)>) -> Ring {
        Ring { replaced, ..self }
    }

    /// A cursor that will see everything from now on.
    pub fn cursor(&self) -> Cursor {
        Cursor(self.first + self.items.len() as u64)
    }

    /// Adds an observation; the oldest goes where the ring is full.
    pub fn push(&mut self, observation: Observation, pool: &mut Observations) {
        if self.items.len() >= self.capacity {
            self.pop(pool);
        }
        self.items.push_back(observation);
    }

    fn pop(&mut self, pool: &mut Observations) {
        if let Some(oldest) = self.items.pop_front() {
            self.first += 1;
            pool.recycle(oldest);
        }
    }

    /// Drops what every stage has seen.
    pub fn forget_before(&mut self, slowest: Cursor, pool: &mut Observations) {
        while self.first < slowest.0 && !self.items.is_empty() {
            self.pop(pool);
        }
    }

    /// How many observations were dropped before this cursor saw them.
    pub fn lost(&self, cursor: Cursor) -> u64 {
        self.first.saturating_sub(cursor.0)
    }

    /// The observations since this cursor, sorted by stamp and sensor.
    pub fn seen(&mut self, cursor: Cursor, filter: Filter<'_>) -> Seen<'_> {
        let skip = cursor.0.saturating_sub(self.first) as usize;
        self.order.clear();
        for (idx, item) in self.items.iter().enumerate().skip(skip) {
            let wanted = match filter {
                Filter::Raw => item.sensor != SensorId::ODOMETER && !is_replaced(&self.replaced, item),
                Filter::Of(sensors) => sensors.contains(&item.sensor),
                Filter::Public => {
                    !(is_replaced(&self.replaced, item)
                        || self.has_odometer && item.sensor != SensorId::ODOMETER && is_odometry(item))
                }
            };
            if wanted {
                self.order.push(idx as u32);
            }
        }
        let items = &self.items;
        self.order.sort_unstable_by_key(|idx| {
            let key = items.get(*idx as usize).map(|item| (item.stamp, item.sensor));
            (key, *idx)
        });
        Seen::of_ring(&self.items, &self.order)
    }

    /// There is something that this cursor has not seen.
    pub fn has_news(&self, cursor: Cursor) -> bool {
        cursor.0 < self.first + self.items.len() as u64
    }

    /// The newest `n` observations, in the order of their arrival.
    pub fn newest(&mut self, n: usize) -> &[Observation] {
        let slice = self.items.make_contiguous();
        slice.get(slice.len().saturating_sub(n)..).unwrap_or(&[])
    }

    /// The newest `n` observations without those that virtual sensors replace, in the order of their arrival.
    pub fn newest_unreplaced(&self, n: usize) -> impl Iterator<Item = &Observation> {
        let newest = self.items.iter().skip(self.items.len().saturating_sub(n));
        newest.filter(|item| !is_replaced(&self.replaced, item))
    }

    /// A cursor in front of the newest `n` observations.
    pub fn before_newest(&self, n: usize) -> Cursor {
        Cursor(self.first + self.items.len().saturating_sub(n) as u64)
    }
}

fn is_replaced(replaced: &[(SensorId, ObservationKind)], item: &Observation) -> bool {
    let is_it =
        |(sensor, kind): &(SensorId, ObservationKind)| *sensor == item.sensor && *kind == item.data.kind();
    replaced.iter().any(is_it)
}

fn is_odometry(item: &Observation) -> bool {
    matches!(item.data, Data::Odometry(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Pose3;
    use crate::messages::{Odometry, SteeringAngle};
    use crate::time::Time;

    fn at(stamp: i64, sensor: u16) -> Observation {
        let data = Data::SteeringAngle(SteeringAngle { angle_rad: stamp as f64 });
        let base_from_sensor = Pose3::identity();
        Observation { sensor: SensorId(sensor), stamp: Time(stamp), base_from_sensor, valid: true, data }
    }

    fn stamps(seen: Seen<'_>) -> Vec<(i64, u16)> {
        seen.iter().map(|o| (o.stamp.0, o.sensor.0)).collect()
    }

    #[test]
    fn late_and_simultaneous_observations_come_sorted_by_stamp_then_sensor() {
        let (mut ring, mut pool) = (Ring::new(16, false), Observations::default());
        let cursor = ring.cursor();
        for (stamp, sensor) in [(30, 1), (20, 0), (30, 0), (10, 2)] {
            ring.push(at(stamp, sensor), &mut pool);
        }
        assert_eq!(stamps(ring.seen(cursor, Filter::Public)), [(10, 2), (20, 0), (30, 0), (30, 1)]);
        let later = ring.cursor();
        ring.push(at(5, 0), &mut pool);
        assert_eq!(stamps(ring.seen(later, Filter::Public)), [(5, 0)], "late data keeps its true stamp");
        assert_eq!(stamps(ring.seen(cursor, Filter::Of(&[SensorId(0)]))), [(5, 0), (20, 0), (30, 0)]);
    }

    #[test]
    fn an_overflow_is_counted_for_the_stage_that_was_too_slow() {
        let (mut ring, mut pool) = (Ring::new(3, false), Observations::default());
        let slow = ring.cursor();
        (0..5).for_each(|k| ring.push(at(k, 0), &mut pool));
        assert_eq!(ring.lost(slow), 2);
        assert_eq!(stamps(ring.seen(slow, Filter::Public)), [(2, 0), (3, 0), (4, 0)]);
        assert_eq!(ring.lost(ring.cursor()), 0);
    }

    #[test]
    fn the_odometer_seat_hides_the_wheels_from_everybody_but_itself() {
        let (mut ring, mut pool) = (Ring::new(8, true), Observations::default());
        let cursor = ring.cursor();
        let odometry = |sensor| Observation { data: Data::Odometry(Odometry::default()), ..at(1, sensor) };
        ring.push(odometry(4), &mut pool);
        ring.push(odometry(SensorId::ODOMETER.0), &mut pool);
        assert_eq!(stamps(ring.seen(cursor, Filter::Public)), [(1, SensorId::ODOMETER.0)]);
        assert_eq!(stamps(ring.seen(cursor, Filter::Raw)), [(1, 4)]);
    }

    #[test]
    fn what_a_virtual_sensor_replaces_is_for_virtual_sensors_only() {
        let mut pool = Observations::default();
        let mut ring = Ring::new(8, false).replacing(vec![(SensorId(0), ObservationKind::SteeringAngle)]);
        let cursor = ring.cursor();
        let other_kind = Observation { data: Data::Odometry(Odometry::default()), ..at(2, 0) };
        [at(1, 0), other_kind, at(3, 1)].into_iter().for_each(|item| ring.push(item, &mut pool));
        assert_eq!(stamps(ring.seen(cursor, Filter::Public)), [(2, 0), (3, 1)]);
        assert_eq!(stamps(ring.seen(cursor, Filter::Raw)), [(2, 0), (3, 1)]);
        assert_eq!(stamps(ring.seen(cursor, Filter::Of(&[SensorId(0)]))), [(1, 0), (2, 0)]);
        let newest: Vec<i64> = ring.newest_unreplaced(3).map(|item| item.stamp.0).collect();
        assert_eq!((newest, ring.newest(3).len()), (vec![2, 3], 3));
    }

    #[test]
    fn what_everybody_has_seen_is_dropped() {
        let (mut ring, mut pool) = (Ring::new(8, false), Observations::default());
        (0..4).for_each(|k| ring.push(at(k, 0), &mut pool));
        let all = ring.cursor();
        assert!(ring.has_news(Cursor(0)) && !ring.has_news(all));
        ring.forget_before(all, &mut pool);
        assert!(ring.newest(4).is_empty());
        assert_eq!(ring.cursor(), all);
    }
}
