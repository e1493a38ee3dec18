#!/usr/bin/env python3
"""Feeds a vehicle with scans of a bare tunnel, made here, and prints each pose.

The tunnel has no features along x: the LiDAR cannot observe that direction, and says so.
"""

import numpy as np

import rali


def tunnel_scan():
    """(N, 6): a scan of 16 rings in a tunnel 4 m wide and 3 m high, from 1 m above the ground."""
    ring, azimuth = np.meshgrid(np.arange(16), np.radians(np.arange(360)))
    elevation = np.radians(-15.0 + 2.0 * ring)
    ray = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                    np.sin(elevation)], axis=-1).reshape(-1, 3)
    with np.errstate(divide="ignore"):
        to_wall = 2.0 / np.abs(ray[:, 1])
        to_ground = np.where(ray[:, 2] < 0.0, 1.0, 2.0) / np.abs(ray[:, 2])
    points = np.minimum(to_wall, to_ground)[:, None] * ray
    zeros = np.zeros(len(points))  # intensity and time: the vehicle stands
    return np.column_stack([points, zeros, zeros, ring.ravel()])


def main():
    vehicle = rali.Vehicle("v1", has_imu=False, range_m=(0.4, 60.0))
    scan = tunnel_scan()
    for k in range(10):
        for output in vehicle.add_scan(scan, stamp_s=0.1 * k):
            if isinstance(output, rali.PoseEstimate):
                sigma_m = np.sqrt(np.diag(output.covariance)[:3])
                print(f"{output.t_s:.1f} s  position {output.T_odom_body[:3, 3].round(3)} m,"
                      f" sigma {sigma_m.round(3)} m, degenerate: {output.degeneracy.degenerate}"
                      f" along {output.degeneracy.direction_odom.round(2)}")


if __name__ == "__main__":
    main()
