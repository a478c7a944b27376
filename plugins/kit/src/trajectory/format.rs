//! The formats of trajectory files, and how one is recognized.

/// A format of a trajectory file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// `t tx ty tz qx qy qz qw` (TUM RGB-D benchmark, Sturm et al. 2012).
    Tum,
    /// The upper three rows of a pose matrix, row by row: 12 numbers, without a stamp (KITTI, Geiger et al. 2012).
    Kitti,
    /// `t x y theta`; what follows on a line is passed over.
    Planar,
    /// A robot log: the poses of its vertices, else the first pose of each laser message.
    Log,
    /// A robot log: the poses of its odometer, in laser and in odometry messages.
    Odometry,
}

impl TrajectoryFormat {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            TrajectoryFormat::Tum => "tum",
            TrajectoryFormat::Kitti => "kitti",
            TrajectoryFormat::Planar => "planar",
            TrajectoryFormat::Log => "log",
            TrajectoryFormat::Odometry => "odometry",
        }
    }

    /// What a line of it looks like.
    pub fn pattern(self) -> &'static str {
        match self {
            TrajectoryFormat::Tum => "t tx ty tz qx qy qz qw",
            TrajectoryFormat::Kitti => "r11 r12 r13 tx r21 r22 r23 ty r31 r32 r33 tz",
            TrajectoryFormat::Planar => "t x y theta",
            TrajectoryFormat::Log | TrajectoryFormat::Odometry => "FLASER, ROBOTLASER1, ODOM, L or O",
        }
    }

    /// The format of a file with this line in it; none where it could be several or is no pose at all.
    pub(super) fn of_line(line: &[u8]) -> Option<TrajectoryFormat> {
        let words: Vec<&str> = std::str::from_utf8(line).ok()?.split_ascii_whitespace().collect();
        let is_number = |word: &&str| word.parse::<f64>().is_ok();
        match (words.first().is_some_and(is_number), words.len()) {
            (false, _) => Some(TrajectoryFormat::Log),
            (true, 4) => Some(TrajectoryFormat::Planar),
            (true, 8) => Some(TrajectoryFormat::Tum),
            (true, 12) => Some(TrajectoryFormat::Kitti),
            (true, _) => None,
        }
    }
}
