//! The states of the mission's automaton, and what may be asked of the robot in each.

use crate::frames::Pose2;
use crate::map::Map;
use crate::messages::{Goal, PersonPosition};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::fmt;

/// States of the automaton.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// There is no map yet.
    NoMap,
    /// There is a map, but nobody knows where the robot is.
    Lost,
    /// Looking for the robot.
    Localizing,
    /// Ready for a goal.
    Waiting,
    /// On the way.
    Navigating,
}

impl State {
    /// The code of the source's appendix B, which other programs know.
    pub fn code(self) -> u8 {
        match self {
            State::Waiting => 2,
            State::Navigating => 3,
            State::Localizing => 4,
            State::NoMap => 5,
            State::Lost => 6,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            State::NoMap => "no_map",
            State::Lost => "lost",
            State::Localizing => "localizing",
            State::Waiting => "waiting",
            State::Navigating => "navigating",
        })
    }
}

/// What anybody may ask of the robot: the one door for the terminal, the network and other programs.
#[doc(alias = "action goal")]
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// Go to these places, one after the other.
    GoTo(Vec<Goal>),
    /// The robot stands here.
    SetPose {
        /// The robot in the map.
        map_from_base: Pose2,
        /// Covariance of x, y, yaw.
        covariance: Matrix3<f64>,
    },
    /// Find out where the robot is.
    Localize,
    /// This is the map from now on.
    SetMap(Box<Map>),
    /// Begin anew: what map builders and a SLAM have made of the map is gone, and the robot stands where the run began.
    Reset,
    /// Forget all goals and stop.
    Cancel,
    /// The person that the mission follows is here: for programs with a tracker of their own. Refused where it follows
    /// nobody.
    PersonAt(PersonPosition),
    /// End the run.
    Shutdown,
}

impl Order {
    /// The word used in messages and recordings.
    pub fn name(&self) -> &'static str {
        match self {
            Order::GoTo(_) => "go_to",
            Order::SetPose { .. } => "set_pose",
            Order::Localize => "localize",
            Order::SetMap(_) => "set_map",
            Order::Reset => "reset",
            Order::Cancel => "cancel",
            Order::PersonAt(_) => "person_at",
            Order::Shutdown => "shutdown",
        }
    }

    /// Whether the automaton obeys in this state (Hernández Alamilla 2005, appendix B, with the transitions that it
    /// leaves open).
    pub fn is_allowed(&self, state: State) -> bool {
        match self {
            Order::GoTo(goals) => state == State::Waiting && !goals.is_empty(),
            Order::SetPose { .. } | Order::Reset => {
                matches!(state, State::Lost | State::Localizing | State::Waiting)
            }
            Order::Localize => matches!(state, State::Lost | State::Waiting),
            Order::SetMap(_) => matches!(state, State::NoMap | State::Lost | State::Waiting),
            Order::Cancel => matches!(state, State::Navigating | State::Localizing),
            Order::PersonAt(_) | Order::Shutdown => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Point2;

    const STATES: [State; 5] =
        [State::NoMap, State::Lost, State::Localizing, State::Waiting, State::Navigating];

    fn goal(x: f64) -> Goal {
        Goal { position: Point2::new(x, 0.0), yaw_rad: None }
    }

    #[test]
    fn every_order_is_allowed_in_exactly_these_states() {
        let pose = Order::SetPose { map_from_base: Pose2::identity(), covariance: Matrix3::identity() };
        let allowed = |order: &Order| STATES.map(|s| u8::from(order.is_allowed(s)));
        assert_eq!(allowed(&Order::GoTo(vec![goal(1.0)])), [0, 0, 0, 1, 0]);
        assert_eq!(allowed(&Order::GoTo(vec![])), [0; 5]);
        assert_eq!(allowed(&pose), [0, 1, 1, 1, 0]);
        assert_eq!(allowed(&Order::Reset), [0, 1, 1, 1, 0]);
        assert_eq!(allowed(&Order::Localize), [0, 1, 0, 1, 0]);
        assert_eq!(allowed(&Order::SetMap(Box::default())), [1, 1, 0, 1, 0]);
        assert_eq!(allowed(&Order::Cancel), [0, 0, 1, 0, 1]);
        assert_eq!(allowed(&Order::PersonAt(PersonPosition::default())), [1; 5]);
        assert_eq!(allowed(&Order::Shutdown), [1; 5]);
    }
}
