//! The keys of `[draw]`, `[[scene]]` and `[world.NAME]` in a study.

use serde::Deserialize;

/// What each seed draws.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rules {
    /// Length of the way from start to goal around what stands there, meters: from, to.
    pub way_m: Option<[f64; 2]>,
    /// No goal is drawn: the robot only has to find itself.
    pub without_goal: bool,
    /// Boxes around the robot that no map shows.
    pub clutter: Option<Clutter>,
    /// Something across the way.
    pub in_the_way: Option<InTheWay>,
    /// People who walk to and fro.
    pub people: Option<People>,
    /// Share of the furniture (boxes with a name that does not begin with `wall`) that stands elsewhere than on the map.
    pub moved_furniture: f64,
}

/// Boxes around the start.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Clutter {
    /// How many.
    pub n: usize,
    /// Edge of each, meters.
    pub size_m: f64,
    /// Their nearest corner from the robot's middle, meters: from, to.
    pub distance_m: [f64; 2],
    /// Only in every so manieth run, the first included.
    pub every: u64,
}

impl Default for Clutter {
    fn default() -> Self {
        Clutter { n: 3, size_m: 0.30, distance_m: [0.6, 2.0], every: 1 }
    }
}

/// What stands across the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A box of 0.3 to 0.6 m.
    Box,
    /// Four legs of 3 cm and a seat at 0.45 m.
    Chair,
    /// Two legs.
    Person,
    /// A pane that light passes.
    Glass,
    /// A shut door that closes the whole passage.
    Door,
}

/// Something across the way.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InTheWay {
    /// What.
    pub kind: Kind,
    /// Whether another way must be left (the default), or none.
    #[serde(default = "yes")]
    pub another_way: bool,
    /// Turned by so much from straight across the way, degrees to either side: from, to.
    #[serde(default)]
    pub turned_deg: [f64; 2],
    /// A person walks away so long after the robot may have come, seconds.
    pub leaves_after_s: Option<f64>,
}

fn yes() -> bool {
    true
}

/// People who walk to and fro on straight free pieces.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct People {
    /// How many: from, to.
    pub n: [u32; 2],
    /// How fast, m/s: from, to.
    pub speed_m_s: [f64; 2],
    /// They stop so far in front of the robot's hull, meters; without it they do not see it.
    pub personal_space_m: Option<f64>,
    /// They walk back after waiting so long for the robot, seconds.
    pub turn_back_after_s: Option<f64>,
}

impl Default for People {
    fn default() -> Self {
        People { n: [1, 3], speed_m_s: [0.5, 1.2], personal_space_m: None, turn_back_after_s: None }
    }
}

impl Rules {
    /// These, and what `other` says over them.
    pub fn with(&self, other: &Rules) -> Rules {
        Rules {
            way_m: other.way_m.or(self.way_m),
            without_goal: self.without_goal || other.without_goal,
            clutter: other.clutter.or(self.clutter),
            in_the_way: other.in_the_way.or(self.in_the_way),
            people: other.people.or(self.people),
            moved_furniture: if other.moved_furniture > 0.0 {
                other.moved_furniture
            } else {
                self.moved_furniture
            },
        }
    }

    /// What is wrong with them: key and message.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let rising =
            |range: &[f64; 2]| range.iter().all(|v| v.is_finite() && *v >= 0.0) && range[0] <= range[1];
        let clutter = self.clutter.unwrap_or_default();
        let people = self.people.unwrap_or_default();
        let ranges = [
            ("way_m", self.way_m.unwrap_or_default()),
            ("clutter.distance_m", clutter.distance_m),
            ("in_the_way.turned_deg", self.in_the_way.map(|it| it.turned_deg).unwrap_or_default()),
            ("people.speed_m_s", people.speed_m_s),
            ("people.n", people.n.map(f64::from)),
        ];
        let mut faults: Vec<_> = ranges
            .into_iter()
            .filter(|(_, range)| !rising(range))
            .map(|(key, range)| {
                (key, format!("is {range:?}, expected two numbers of 0 or more, the lower first"))
            })
            .collect();
        if !(0.0..=1.0).contains(&self.moved_furniture) {
            faults.push(("moved_furniture", format!("is {}, expected 0 to 1", self.moved_furniture)));
        }
        if clutter.every == 0 || !(clutter.size_m.is_finite() && clutter.size_m > 0.0) {
            faults.push(("clutter", "expected a size_m above 0 and an `every` of 1 or more".to_owned()));
        }
        let care = [
            ("people.personal_space_m", people.personal_space_m),
            ("people.turn_back_after_s", people.turn_back_after_s),
        ];
        for (key, value) in care {
            if let Some(wrong) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
                faults.push((key, format!("is {wrong}, expected 0 or more")));
            }
        }
        if people.turn_back_after_s.is_some() && people.personal_space_m.is_none() {
            faults.push(("people.turn_back_after_s", "goes with people.personal_space_m only".to_owned()));
        }
        if self.without_goal && (self.way_m.is_some() || self.in_the_way.is_some()) {
            faults.push((
                "without_goal",
                "goes with neither way_m nor in_the_way, which need a goal".to_owned(),
            ));
        }
        faults
    }
}
