#include "rali/wire/definitions.hpp"

#include <algorithm>
#include <vector>

#include "rali/wire/message_kind.hpp"

namespace rali::wire {
namespace {

/// One message: its fields in ROS 1 and ROS 2, and the messages in them, in order.
struct Definition {
  std::string_view type;  ///< in ROS 1 style
  std::string_view md5;   ///< of ROS 1, nested types included; empty if never written alone
  std::string_view ros1;
  std::string_view ros2;   ///< empty: as ros1
  std::string_view parts;  ///< nested types, separated by blanks
};

constexpr Definition kDefinitions[] = {
    {"std_msgs/Header",
     {},
     "uint32 seq\ntime stamp\nstring frame_id\n",
     "builtin_interfaces/Time stamp\nstring frame_id\n",
     "builtin_interfaces/Time"},
    {"builtin_interfaces/Time", {}, "", "int32 sec\nuint32 nanosec\n", ""},
    {"builtin_interfaces/Duration", {}, "", "int32 sec\nuint32 nanosec\n", ""},
    {"std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", "string data\n", "", ""},
    {"std_msgs/ColorRGBA", {}, "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n", "", ""},
    {"geometry_msgs/Vector3", {}, "float64 x\nfloat64 y\nfloat64 z\n", "", ""},
    {"geometry_msgs/Point", {}, "float64 x\nfloat64 y\nfloat64 z\n", "", ""},
    {"geometry_msgs/Quaternion", {}, "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n", "", ""},
    {"geometry_msgs/Pose",
     {},
     "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
     "",
     "geometry_msgs/Point geometry_msgs/Quaternion"},
    {"geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5",
     "std_msgs/Header header\ngeometry_msgs/Pose pose\n", "", "std_msgs/Header geometry_msgs/Pose"},
    {"geometry_msgs/Transform",
     {},
     "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
     "",
     "geometry_msgs/Vector3 geometry_msgs/Quaternion"},
    {"geometry_msgs/TransformStamped",
     {},
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
     "",
     "std_msgs/Header geometry_msgs/Transform"},
    {"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec",
     "geometry_msgs/TransformStamped[] transforms\n", "", "geometry_msgs/TransformStamped"},
    {"geometry_msgs/PoseWithCovariance",
     {},
     "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
     "",
     "geometry_msgs/Pose"},
    {"geometry_msgs/Twist",
     {},
     "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
     "",
     "geometry_msgs/Vector3"},
    {"geometry_msgs/TwistWithCovariance",
     {},
     "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
     "",
     "geometry_msgs/Twist"},
    {"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n",
     "", "std_msgs/Header geometry_msgs/PoseWithCovariance geometry_msgs/TwistWithCovariance"},
    {"nav_msgs/MapMetaData",
     {},
     "time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
     "geometry_msgs/Pose origin\n",
     "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n"
     "geometry_msgs/Pose origin\n",
     "builtin_interfaces/Time geometry_msgs/Pose"},
    {"nav_msgs/OccupancyGrid", "3381f2d731d4076ec5c71b0759edbe4e",
     "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n", "",
     "std_msgs/Header nav_msgs/MapMetaData"},
    {"nav_msgs/Path", "6227e2b7e9cce15051f669a5e197bbf7",
     "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n", "",
     "std_msgs/Header geometry_msgs/PoseStamped"},
    {"sensor_msgs/PointField",
     {},
     "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\n"
     "uint8 FLOAT32=7\nuint8 FLOAT64=8\n"
     "string name\nuint32 offset\nuint8 datatype\nuint32 count\n",
     "",
     ""},
    {"sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181",
     "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
     "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
     "", "std_msgs/Header sensor_msgs/PointField"},
    {"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2",
     "std_msgs/Header header\n"
     "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
     "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
     "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
     "", "std_msgs/Header geometry_msgs/Quaternion geometry_msgs/Vector3"},
    {"diagnostic_msgs/KeyValue", {}, "string key\nstring value\n", "", ""},
    {"diagnostic_msgs/DiagnosticStatus",
     {},
     "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
     "byte level\nstring name\nstring message\nstring hardware_id\n"
     "diagnostic_msgs/KeyValue[] values\n",
     "",
     "diagnostic_msgs/KeyValue"},
    {"diagnostic_msgs/DiagnosticArray", "60810da900de1dd6ddd437c3503511da",
     "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n", "",
     "std_msgs/Header diagnostic_msgs/DiagnosticStatus"},
    {"sensor_msgs/CompressedImage",
     {},
     "",
     "std_msgs/Header header\nstring format\nuint8[] data\n",
     "std_msgs/Header"},
    {"visualization_msgs/UVCoordinate", {}, "", "float32 u\nfloat32 v\n", ""},
    {"visualization_msgs/MeshFile", {}, "", "string filename\nuint8[] data\n", ""},
    {"visualization_msgs/Marker", "4048c9de2a16f4ae8e0538085ebf1b97",
     "uint8 ARROW=0\nuint8 CUBE=1\nuint8 SPHERE=2\nuint8 CYLINDER=3\nuint8 LINE_STRIP=4\n"
     "uint8 LINE_LIST=5\nuint8 CUBE_LIST=6\nuint8 SPHERE_LIST=7\nuint8 POINTS=8\n"
     "uint8 TEXT_VIEW_FACING=9\nuint8 MESH_RESOURCE=10\nuint8 TRIANGLE_LIST=11\n"
     "uint8 ADD=0\nuint8 MODIFY=0\nuint8 DELETE=2\nuint8 DELETEALL=3\n"
     "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
     "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
     "duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
     "std_msgs/ColorRGBA[] colors\nstring text\nstring mesh_resource\n"
     "bool mesh_use_embedded_materials\n",
     "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\n"
     "int32 LINE_LIST=5\nint32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\n"
     "int32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\nint32 TRIANGLE_LIST=11\n"
     "int32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n"
     "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
     "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
     "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
     "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
     "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n"
     "string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n"
     "bool mesh_use_embedded_materials\n",
     "std_msgs/Header geometry_msgs/Pose geometry_msgs/Vector3 std_msgs/ColorRGBA "
     "builtin_interfaces/Duration geometry_msgs/Point sensor_msgs/CompressedImage "
     "visualization_msgs/UVCoordinate visualization_msgs/MeshFile"},
    {"visualization_msgs/MarkerArray", "d155b9ce5188fbaf89745847fd5882d7",
     "visualization_msgs/Marker[] markers\n", "", "visualization_msgs/Marker"},
    {"rali_msgs/Range", "cb1a914035cad35f776eb0d7bb631b00",
     "std_msgs/Header header\nstring from\nstring to\nfloat64 range_m\nfloat32 sigma_m\n"
     "float32 rssi\nfloat32 rssi_first_path\nuint64 device_time_ns\nuint8 flags\n",
     "", "std_msgs/Header"},
    {"livox_ros_driver/CustomPoint",
     {},
     "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\nuint8 reflectivity\nuint8 tag\n"
     "uint8 line\n",
     "",
     ""},
    {"livox_ros_driver/CustomMsg", "e4d6829bdfe657cb6c21a746c86b21a6",
     "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
     "livox_ros_driver/CustomPoint[] points\n",
     "", "std_msgs/Header livox_ros_driver/CustomPoint"},
    {"livox_ros_driver2/CustomPoint",
     {},
     "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\nuint8 reflectivity\nuint8 tag\n"
     "uint8 line\n",
     "",
     ""},
    {"livox_ros_driver2/CustomMsg", "e4d6829bdfe657cb6c21a746c86b21a6",
     "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\nuint8[3] rsvd\n"
     "livox_ros_driver2/CustomPoint[] points\n",
     "", "std_msgs/Header livox_ros_driver2/CustomPoint"},
};

const Definition* find(std::string_view type) {
  for (const Definition& definition : kDefinitions) {
    if (definition.type == type) return &definition;
  }
  return nullptr;
}

std::string_view fields(const Definition& definition, bool ros2) {
  return ros2 && !definition.ros2.empty() ? definition.ros2 : definition.ros1;
}

/// The nested types, depth first, each once, in the order of their first appearance.
void collect(const Definition& definition, bool ros2, std::vector<const Definition*>& found) {
  std::string_view rest = definition.parts;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    const Definition* part = find(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    // Types that only ROS 1 or only ROS 2 has are empty in the other.
    if (part == nullptr || fields(*part, ros2).empty()) continue;
    if (std::find(found.begin(), found.end(), part) != found.end()) continue;
    found.push_back(part);
    collect(*part, ros2, found);
  }
}

}  // namespace

std::string message_definition(std::string_view type_name, Encoding encoding) {
  const bool ros2 = encoding == Encoding::kCdr;
  const Definition* definition = find(ros1_type_name(type_name));
  if (definition == nullptr) return {};
  std::string text(fields(*definition, ros2));
  std::vector<const Definition*> parts;
  collect(*definition, ros2, parts);
  for (const Definition* part : parts) {
    text += std::string(80, '=') + "\nMSG: " + std::string(part->type) + "\n";
    text += fields(*part, ros2);
  }
  return text;
}

std::string_view message_md5(std::string_view type_name) {
  const Definition* definition = find(ros1_type_name(type_name));
  return definition == nullptr ? std::string_view{} : definition->md5;
}

}  // namespace rali::wire
