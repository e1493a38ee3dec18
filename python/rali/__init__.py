"""RaLI: maps with several vehicles where LiDAR is degenerate.

    import rali
    summary = rali.map("run.bag", out="out", settings={"output.map_voxel_m": 0.1})
    trajectory = rali.read_trajectory("out/trajectory/run.tum")

All names end with their unit; T_a_b is the pose of b in a, as a (4, 4) array.
"""

from rali._errors import Error, InputError, MachineError, NoAnswerError, SettingsError
from rali._rali import (
    CloudErrors, Degeneracy, ErrorStatistics, Evaluation, Finding, Keyframe, MapCloud, MapProgress,
    MapSummary, PoseEstimate, RangeResult, RangeTable, RelativeError, TrackErrors, Trajectory,
    Vehicle, VehicleSummary, evaluate, map, read_map, read_ranges, read_trajectory, version)

__version__ = version()

__all__ = [
    "CloudErrors", "Degeneracy", "Error", "ErrorStatistics", "Evaluation", "Finding", "InputError",
    "Keyframe", "MachineError", "MapCloud", "MapProgress", "MapSummary", "NoAnswerError",
    "PoseEstimate", "RangeResult", "RangeTable", "RelativeError", "SettingsError", "TrackErrors",
    "Trajectory", "Vehicle", "VehicleSummary", "evaluate", "map", "read_map", "read_ranges",
    "read_trajectory", "version"]
