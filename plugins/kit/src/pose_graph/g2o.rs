//! Pose graphs in files of g2o: `VERTEX_SE2 id x y theta`, `EDGE_SE2 from to x y theta I11 I12 I13 I22 I23 I33`,
//! `FIX id`; meters and radians, plain or gzip. Kümmerle, Grisetti, Strasdat, Konolige, Burgard, "g2o: a general
//! framework for graph optimization" (2011).

use super::constraint::Constraint;
use super::graph::PoseGraph;
use super::kernel::RobustKernel;
use crate::log_file::lines::{Line, Lines};
use crate::log_file::words::{Words, shown};
use crate::log_file::{FaultKind, LineFault, LogError};
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Why a graph cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum G2oError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot read the file: {source}; give the path of a g2o file, plain or gzip", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is no graph in it.
    #[error("{}: {found}, expected lines of `{EDGE} from to x y theta I11 I12 I13 I22 I23 I33`", path.display())]
    NoGraph {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
    /// A line cannot be read. A graph without it would be another one, so none is left out.
    #[error("{}:{}: {} is {}, expected {}", path.display(), fault.line, fault.field, fault.found, fault.expected)]
    Line {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: Box<LineFault>,
    },
}

/// A graph as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct G2oGraph {
    /// Poses in the order of their numbers, and constraints with the quadratic kernel.
    pub graph: PoseGraph,
    /// What the file calls each pose.
    pub ids: Vec<u64>,
    /// The file gives the poses; else they are those of a tree of constraints.
    pub has_poses: bool,
}

const EDGE: &str = "EDGE_SE2";
const VERTEX: &str = "VERTEX_SE2";

/// Reads a graph in the plane.
///
/// # Errors
/// [`G2oError`], with the line.
pub fn read_g2o(path: &Path) -> Result<G2oGraph, G2oError> {
    let mut lines = Lines::open(path).map_err(|error| unreadable(path, error))?;
    let faulty = |fault: LineFault| G2oError::Line { path: path.to_owned(), fault: Box::new(fault) };
    let mut file = File::default();
    loop {
        let damage = match lines.next() {
            Line::Whole | Line::Unfinished => None,
            Line::TooLong => Some("a line without end".to_owned()),
            Line::Damaged(damage) => Some(damage.found),
            Line::End => break,
        };
        let fault = match damage {
            None => file.take(lines.number, lines.bytes.trim_ascii()).err(),
            Some(found) => {
                let words = Words::new(lines.number, &[]).of("file");
                Some(words.fault(FaultKind::LineTooLong, "text", found, "a file that is whole"))
            }
        };
        fault.map_or(Ok(()), |fault| Err(faulty(fault)))?;
    }
    if file.edges.is_empty() {
        let found = format!("no {EDGE} in {} lines", lines.number);
        return Err(G2oError::NoGraph { path: path.to_owned(), found });
    }
    file.graph().map_err(faulty)
}

fn unreadable(path: &Path, error: LogError) -> G2oError {
    let path = path.to_owned();
    match error {
        LogError::Unreadable { source, .. } => G2oError::Unreadable { path, source },
        LogError::Folder { .. } => G2oError::NoGraph { path, found: "is a folder".to_owned() },
        LogError::Empty { .. } => G2oError::NoGraph { path, found: "the file is empty".to_owned() },
        LogError::NoRecords { found, .. } => G2oError::NoGraph { path, found },
    }
}

/// What the lines say.
#[derive(Default)]
struct File {
    poses: BTreeMap<u64, Pose2>,
    fixed: BTreeMap<u64, u64>,
    edges: Vec<Edge>,
}

struct Edge {
    line: u64,
    ids: [u64; 2],
    from_to: Pose2,
    information: Matrix3<f64>,
}

impl File {
    fn take(&mut self, line: u64, text: &[u8]) -> Result<(), LineFault> {
        if text.is_empty() || text.starts_with(b"#") {
            return Ok(());
        }
        let mut words = Words::new(line, text);
        let tag = words.word("tag")?;
        let mut words = match tag {
            b"VERTEX_SE2" => words.of(VERTEX),
            b"EDGE_SE2" => words.of(EDGE),
            b"FIX" => words.of("FIX"),
            _ => {
                let expected = format!("{VERTEX}, {EDGE} or FIX: only graphs in the plane are read");
                return Err(words.of("line").fault(FaultKind::OutOfRange, "tag", shown(tag), &expected));
            }
        };
        match tag {
            b"VERTEX_SE2" => {
                let node = id(&mut words, "id")?;
                let pose = words.pose(["x", "y", "theta"], 1.0)?;
                if self.poses.insert(node, pose).is_some() {
                    let found = format!("{node}, which an earlier line has, too");
                    return Err(words.fault(FaultKind::OutOfRange, "id", found, "one line a pose"));
                }
            }
            b"EDGE_SE2" => {
                let ids = [id(&mut words, "from")?, id(&mut words, "to")?];
                let from_to = words.pose(["x", "y", "theta"], 1.0)?;
                let information = information(&mut words)?;
                self.edges.push(Edge { line, ids, from_to, information });
            }
            _ => {
                self.fixed.insert(id(&mut words, "id")?, line);
            }
        }
        match words.n_left() {
            0 => Ok(()),
            n => {
                let found = format!("followed by {n} more words");
                Err(words.fault(FaultKind::CountDiffers, "end", found, "the end of the line"))
            }
        }
    }

    fn graph(self) -> Result<G2oGraph, LineFault> {
        let has_poses = !self.poses.is_empty();
        let mut known: BTreeSet<u64> = self.poses.keys().copied().collect();
        if !has_poses {
            known.extend(self.edges.iter().flat_map(|edge| edge.ids));
        }
        let ids: Vec<u64> = known.into_iter().collect();
        let mut graph = PoseGraph::default();
        let refused = |line: u64, tag, field: &str, found: String| {
            Words::new(line, &[]).of(tag).fault(
                FaultKind::OutOfRange,
                field,
                found,
                "what makes a pose graph",
            )
        };
        for id in &ids {
            let pose = self.poses.get(id).copied().unwrap_or_else(Pose2::identity);
            graph.add_pose(&pose).map_err(|fault| refused(0, VERTEX, "pose", fault.to_string()))?;
        }
        let node = |line: u64, tag, field, id: u64| {
            let missing = || refused(line, tag, field, format!("pose {id}, which no {VERTEX} describes"));
            ids.binary_search(&id).map_err(|_| missing())
        };
        for Edge { line, ids: [from, to], from_to, information } in self.edges {
            let (from, to) = (node(line, EDGE, "from", from)?, node(line, EDGE, "to", to)?);
            let constraint =
                Constraint { from: Some(from), to, from_to, information, kernel: RobustKernel::Quadratic };
            graph.add(constraint).map_err(|fault| refused(line, EDGE, "constraint", fault.to_string()))?;
        }
        for (id, line) in self.fixed {
            let fixed = node(line, "FIX", "id", id)?;
            graph.fix(fixed).map_err(|fault| refused(line, "FIX", "id", fault.to_string()))?;
        }
        if !has_poses {
            graph.start_from_tree();
        }
        Ok(G2oGraph { graph, ids, has_poses })
    }
}

fn id(words: &mut Words<'_>, field: &str) -> Result<u64, LineFault> {
    let word = words.word(field)?;
    let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    number.ok_or_else(|| words.fault(FaultKind::NotANumber, field, shown(word), "a whole number, 0 or more"))
}

/// The upper half, row by row.
fn information(words: &mut Words<'_>) -> Result<Matrix3<f64>, LineFault> {
    let mut upper = [0.0; 6];
    for (value, field) in upper.iter_mut().zip(["I11", "I12", "I13", "I22", "I23", "I33"]) {
        *value = words.number(field)?;
    }
    let [xx, xy, xt, yy, yt, tt] = upper;
    Ok(Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt))
}
