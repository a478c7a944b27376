//! Orders that came from outside, so that a replay can give them again in the same step.

use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::map_code::{put_map, read_map};
use super::outputs::{place2, points, put_points};
use super::pose::numbers2;
use nalgebra::Matrix3;
use rumbo_core::engine::Order;
use rumbo_core::frames::Point2;
use rumbo_core::messages::{Goal, PathPoint, PersonPosition};

/// Writes an order.
pub fn put_order(cdr: &mut CdrWriter, order: &Order) {
    cdr.begin().text(order.name());
    let goals: &[Goal] = if let Order::GoTo(goals) = order { goals } else { &[] };
    let points: Vec<PathPoint> =
        goals.iter().map(|goal| PathPoint { position: goal.position, yaw_rad: goal.yaw_rad }).collect();
    put_points(cdr, &points);
    match order {
        Order::SetPose { map_from_base, covariance } => {
            cdr.f64s(&numbers2(map_from_base));
            cdr.f64s(covariance.as_slice());
        }
        // The place where a pose goes, without a direction, and the deviation where a covariance goes.
        Order::PersonAt(person) => {
            cdr.f64s(&[person.position.x, person.position.y]);
            cdr.f64s(&[person.deviation_m]);
        }
        _ => {
            cdr.f64s(&[]);
            cdr.f64s(&[]);
        }
    }
    let mut map = CdrWriter::default();
    if let Order::SetMap(new) = order {
        put_map(&mut map, new);
    }
    cdr.octets(map.bytes());
}

/// Reads an order.
pub fn read_order(message: &[u8]) -> Result<Order, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    let (name, goals) = (cdr.text()?, points(&mut cdr)?);
    let (pose, covariance) = (cdr.f64s()?, cdr.f64s()?);
    let bad = |found: String| CdrError::Value { field: "kind", found, expected: "a known order, complete" };
    Ok(match name.as_str() {
        "go_to" => {
            let goal = |point: &PathPoint| Goal { position: point.position, yaw_rad: point.yaw_rad };
            Order::GoTo(goals.iter().map(goal).collect())
        }
        "set_pose" => match (place2(&pose), covariance.len()) {
            (Some(map_from_base), 9) => {
                Order::SetPose { map_from_base, covariance: Matrix3::from_column_slice(&covariance) }
            }
            _ => return Err(bad(name)),
        },
        "localize" => Order::Localize,
        "set_map" => Order::SetMap(Box::new(read_map(cdr.octets()?)?)),
        "person_at" => match (pose.as_slice(), covariance.as_slice()) {
            ([x, y], [deviation_m]) => {
                let (position, deviation_m) = (Point2::new(*x, *y), *deviation_m);
                Order::PersonAt(PersonPosition { position, deviation_m })
            }
            _ => return Err(bad(name)),
        },
        "reset" => Order::Reset,
        "cancel" => Order::Cancel,
        "shutdown" => Order::Shutdown,
        _ => return Err(bad(name)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::pose2;
    use rumbo_core::map::{Grid, Map};

    #[test]
    fn every_order_comes_back() {
        let map = Map { grid: Grid::unknown(2, 2, 0.5).ok(), ..Map::default() };
        let goal = |yaw_rad| Goal { position: Point2::new(1.0 / 3.0, -2.0), yaw_rad };
        let orders = [
            Order::GoTo(vec![goal(None), goal(Some(0.5))]),
            Order::SetPose { map_from_base: pose2(1.0, 2.0, 0.1), covariance: Matrix3::new_scaling(0.3) },
            Order::Localize,
            Order::SetMap(Box::new(map)),
            Order::PersonAt(PersonPosition { position: Point2::new(0.1, 1.0 / 3.0), deviation_m: 0.7 }),
            Order::Reset,
            Order::Cancel,
            Order::Shutdown,
        ];
        let mut cdr = CdrWriter::default();
        for order in orders {
            put_order(&mut cdr, &order);
            assert_eq!(read_order(cdr.bytes()), Ok(order));
        }
        cdr.begin().text("dance");
        assert!(read_order(cdr.bytes()).is_err());
    }
}
