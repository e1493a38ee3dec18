#pragma once

// Texts that help(rali.map) and the like print. Shapes in parentheses, units in brackets.

namespace rali::python {

inline constexpr const char* kMapDoc =
    R"(Map recordings as `rali map` does: same engine, same files.

inputs     recording(s) (.bag .mcap .db3, scan folders), one vehicle each, or one fleet.yaml
out        folder of the results
preset     robust (default) or paper
settings   dict of keys of docs/reference/settings.md; text values are YAML
formats    of map.*: pcd, ply, las
threads    0: one per core; results do not depend on it
progress   called with a MapProgress; False stops the run at the data time reached. An exception
           does the same and then leaves rali.map. Ctrl-C works with and without it.
finding    called with each Finding

Returns a MapSummary. Raises SettingsError (also: `out` has results of an earlier run), InputError,
MachineError. Other threads of Python run meanwhile.)";

inline constexpr const char* kEvaluateDoc =
    R"(Compare results with a ground truth, as `rali evaluate`.

input         folder of a run, a trajectory (TUM), or a cloud
truth         folder with <vehicle>.tum, or one file
mesh          true surfaces; default: mesh.ply beside the truth, if there
alignment     se3, yaw, origin, none
each          one alignment per vehicle instead of one for the fleet
distances_m   of the relative pose error [m]
T_body_truth  (4, 4), pose in the body of what the truth follows
out           folder of evaluation.json; default: that of the run

Returns an Evaluation; str() of it is the table. Raises SettingsError, InputError, NoAnswerError,
MachineError.)";

inline constexpr const char* kVehicleDoc = R"(One vehicle's odometry, stepped by hand.

name             of the vehicle
T_body_lidar     (4, 4), pose of the LiDAR in the body; default: identity
T_body_imu       (4, 4), pose of the IMU in the body; default: identity
has_imu          False: LiDAR alone
range_m          points nearer or farther are left out [m]
antennas_body_m  (N, 3) positions of the vehicle's antennas in the body [m]
peers            dict: name of a vehicle or beacon -> (N, 3) positions of its antennas [m]
preset, settings as of rali.map; keys odometry.*, ranging.*, vehicle.*

Feed events in order of time, a scan at the time of its last point. Each add_* returns a list of what
follows: PoseEstimate, Keyframe, RangeResult, Finding. Same events: same outputs, bit by bit.)";

inline constexpr const char* kAddScanDoc = R"(Add one scan.

points    (N, 3) to (N, 6) float: x, y, z [m] in the LiDAR's frame, intensity, dt_s [s after
          stamp_s], ring. Points that are not finite, zero or out of range are left out.
stamp_s   time of dt_s = 0 [s]
deskewed  all points refer to the time of the last one

The pose comes with the event that completes the inertial data of the scan.)";

inline constexpr const char* kAddImuDoc = R"(Add inertial samples.

rows  (N, 7) float64: stamp_s [s], angular rate x y z [rad/s], specific force x y z [m/s^2], in the
      frame of the IMU; at rest with z up the force is +9.81 in z.)";

inline constexpr const char* kAddRangeDoc = R"(Add one range between two antennas [m].

One end is this vehicle, the other one of its peers. sigma_m = 0: that of the settings.)";

inline constexpr const char* kAddPeerStateDoc = R"(State whether a peer stands.

Ranges to it are used while it does; repeat the state at least once a second.)";

inline constexpr const char* kFinishDoc = "The data have ended: process what waits for more.";

inline constexpr const char* kReadTrajectoryDoc = R"(Read a TUM file and the .cov.csv beside it.

Returns a Trajectory: stamp_ns (N,) int64, stamp_s (N,) [s], poses (N, 4, 4), covariances (N, 6, 6) in
the order x y z rx ry rz [m, rad] about fixed axes, or None. Arrays are views, not copies.)";

inline constexpr const char* kReadMapDoc = R"(Read map.pcd, map.ply, or any PCD, PLY or KITTI .bin.

Returns a MapCloud: xyz_m (N, 3) float32 [m]; intensity, sigma_m [m], seen, vehicle (N,), or None
where the file has no such field. Arrays are views, not copies.)";

inline constexpr const char* kReadRangesDoc = R"(Read ranges.csv of a run, or one written by hand.

Returns a RangeTable of columns (N,): stamp_ns, range_m, predicted_m, residual_m, sigma_m, bias_m [m],
p_los, used (bool); from_vehicle, to_vehicle, reason (lists). NaN: not known.)";

}  // namespace rali::python
