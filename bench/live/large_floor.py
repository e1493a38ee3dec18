#!/usr/bin/env python3
"""Prints a scene: a storey of 72 rooms along three corridors, an hour of exploration.

What grows in a long mission? Usage:
    large_floor.py > large_floor.yaml
    missions.py --scene large_floor.yaml --duration 4500 --cases lossless
"""

ROOMS = 12  # on each side of a corridor
ROOM_M = (8.0, 7.8)
CORRIDOR_M = 2.4
WALL_M = 0.2
BETWEEN_M = 2 * ROOM_M[1] + CORRIDOR_M + 3 * WALL_M  # one corridor to the next
LENGTH_M = ROOMS * (ROOM_M[0] + WALL_M) - WALL_M
CROSS_M = 2.4  # width of the corridor that joins the three


def rectangle(x_m, y_m, wide_m, high_m):
    sides = [x_m, y_m, x_m + wide_m, y_m + high_m]
    return f"    - {{rectangle: [{', '.join(f'{s:.2f}' for s in sides)}]}}"


def door(x_m, y_m):
    return f"    - {{at: [{x_m:.2f}, {y_m:.2f}], yaw_deg: 90, depth_m: {WALL_M}, width_m: 1.2}}"


def pillar(x_m, y_m):
    return f"    - {{at: [{x_m:.2f}, {y_m:.2f}], size_m: [0.5, 0.8]}}"


def main():
    areas, doors, pillars = [], [], []
    for corridor in range(3):
        y_m = corridor * BETWEEN_M
        # Into the cross corridor, without a door.
        areas.append(rectangle(-WALL_M - CROSS_M, y_m, LENGTH_M + WALL_M + CROSS_M, CORRIDOR_M))
        for room in range(ROOMS):
            x_m = room * (ROOM_M[0] + WALL_M)
            door_x_m = x_m + 0.5 * ROOM_M[0]
            areas.append(rectangle(x_m, y_m + CORRIDOR_M + WALL_M, *ROOM_M))
            areas.append(rectangle(x_m, y_m - WALL_M - ROOM_M[1], *ROOM_M))
            doors.append(door(door_x_m, y_m + CORRIDOR_M + 0.5 * WALL_M))
            doors.append(door(door_x_m, y_m - 0.5 * WALL_M))
            # Rooms differ; no furniture blocks a corridor.
            for side, depth_m in ((1, 2.0 + 0.3 * room), (-1, 5.5 - 0.25 * room)):
                wall_y_m = y_m + CORRIDOR_M + WALL_M if side > 0 else y_m - WALL_M
                pillars.append(pillar(x_m + 1.5 + 0.2 * room, wall_y_m + side * depth_m))
    areas.append(rectangle(-WALL_M - CROSS_M, 0.0, CROSS_M, 2 * BETWEEN_M + CORRIDOR_M))
    print("schema: 1\nseed: 301\nfloor_plan:\n  height_m: 2.8\n  areas:")
    print("\n".join(areas))
    print("  doors:")
    print("\n".join(doors))
    print("  pillars:")
    print("\n".join(pillars))
    print("vehicles:")
    for x_m in (1.0, 3.0, 5.0):
        print(f"  - {{start: [{x_m}, 1.2]}}")


main()
