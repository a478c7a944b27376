//! The fields of ROS 2's messages, as the interface files of its packages name them.

use crate::recording::layout::Layout;

macro_rules! nested {
    (time) => {
        "================================================================================\n\
         MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    };
    (header) => {
        concat!(
            "================================================================================\n\
             MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n",
            nested!(time)
        )
    };
    (pose) => {
        "================================================================================\n\
         MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n\
         ================================================================================\n\
         MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n\
         ================================================================================\n\
         MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    };
    (vector) => {
        "================================================================================\n\
         MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    };
}

/// A planar scan.
pub const LASER_SCAN: Layout = Layout {
    name: "sensor_msgs/msg/LaserScan",
    text: concat!(
        "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n\
         float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n\
         float32[] intensities\n",
        nested!(header)
    ),
};

/// Points in space.
pub const POINT_CLOUD: Layout = Layout {
    name: "sensor_msgs/msg/PointCloud2",
    text: concat!(
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n\
         uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        nested!(header),
        "================================================================================\n\
         MSG: sensor_msgs/PointField\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n"
    ),
};

/// A place and how sure it is.
pub const POSE: Layout = Layout {
    name: "geometry_msgs/msg/PoseWithCovarianceStamped",
    text: concat!(
        "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n",
        nested!(header),
        "================================================================================\n\
         MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n",
        nested!(pose)
    ),
};

/// A place.
pub const PLACE: Layout = Layout {
    name: "geometry_msgs/msg/PoseStamped",
    text: concat!("std_msgs/Header header\ngeometry_msgs/Pose pose\n", nested!(header), nested!(pose)),
};

/// A path.
pub const PATH: Layout = Layout {
    name: "nav_msgs/msg/Path",
    text: concat!(
        "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n",
        nested!(header),
        "================================================================================\n\
         MSG: geometry_msgs/PoseStamped\nstd_msgs/Header header\ngeometry_msgs/Pose pose\n",
        nested!(pose)
    ),
};

/// A map of cells.
pub const GRID: Layout = Layout {
    name: "nav_msgs/msg/OccupancyGrid",
    text: concat!(
        "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n",
        nested!(header),
        "================================================================================\n\
         MSG: nav_msgs/MapMetaData\nbuiltin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\n\
         uint32 height\ngeometry_msgs/Pose origin\n",
        nested!(pose)
    ),
};

/// Where frames are.
pub const TRANSFORMS: Layout = Layout {
    name: "tf2_msgs/msg/TFMessage",
    text: concat!(
        "geometry_msgs/TransformStamped[] transforms\n\
         ================================================================================\n\
         MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n\
         geometry_msgs/Transform transform\n\
         ================================================================================\n\
         MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n\
         ================================================================================\n\
         MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        nested!(vector),
        nested!(header)
    ),
};

/// A velocity.
pub const TWIST: Layout = Layout {
    name: "geometry_msgs/msg/TwistStamped",
    text: concat!(
        "std_msgs/Header header\ngeometry_msgs/Twist twist\n\
         ================================================================================\n\
         MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
        nested!(vector),
        nested!(header)
    ),
};

/// A line of a log.
pub const LOG: Layout = Layout {
    name: "rcl_interfaces/msg/Log",
    text: concat!(
        "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\nstring file\nstring function\n\
         uint32 line\n",
        nested!(time)
    ),
};

/// An odometer's reading.
pub const ODOMETRY: &str = "nav_msgs/msg/Odometry";

/// Attitude, rates and accelerations.
pub const IMU: &str = "sensor_msgs/msg/Imu";
