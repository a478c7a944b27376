//! Poses in the plane that agree best with what is known between pairs of them.
//!
//! Grisetti, Kümmerle, Stachniss, Burgard, "A tutorial on graph-based SLAM" (2010): least squares over the poses, where
//! each constraint says what the one pose is as seen from the other, and how surely. Levenberg-Marquardt on the sparse
//! normal equations; their structure is analyzed once and kept while the graph keeps its shape. Constraints that may be
//! wrong (closed loops) take a robust kernel, so that one false loop does not bend the map.
//!
//! Cost: the sum of `rho(e^T Omega e)` over all constraints, without a factor 1/2; `e` is the measured pose subtracted
//! from the actual one, x and y in the measured frame, then the turn wrapped to half a turn. The covariances are those of
//! this cost read as a sum of squares over unit variances.

mod component;
mod constraint;
mod g2o;
mod graph;
mod kernel;
mod normal_equations;
mod optimizer;
mod start;

pub use constraint::{Constraint, Linearized};
pub use g2o::{G2oError, G2oGraph, read_g2o};
pub use graph::{GraphFault, PoseGraph};
pub use kernel::RobustKernel;
pub use optimizer::{Covariances, GraphOptimizer, OptimizeSettings, OptimizeStatus, Optimized};

#[cfg(test)]
mod tests;
