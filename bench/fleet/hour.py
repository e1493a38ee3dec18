#!/usr/bin/env python3
"""Prints a scene: two vehicles that change places in two rooms for an hour.

What grows although nothing new is seen? Usage:
    hour.py > hour.yaml && rali simulate hour.yaml --duration 3600 -o hour
"""

HEAD = """\
schema: 1
seed: 301
floor_plan:
  height_m: 2.8
  areas:
    - {rectangle: [0, 0, 10, 8]}
    - {rectangle: [10.2, 0, 18, 8]}
  doors:
    - {at: [10.1, 4], depth_m: 0.2, width_m: 1.6}
  clutter: 12
vehicles:
  - {start: [2, 2]}
  - {start: [2, 6]}
rounds:"""
ROUNDS = 60
V1 = "[[2, 2], [8, 3.5], [12, 4], [16, 2], [12, 4], [8, 3.5], [2, 2]]"
V2 = "[[2, 6], [8, 4.5], [12, 4], [16, 6], [12, 4], [8, 4.5], [2, 6]]"

print(HEAD)
for _ in range(ROUNDS):
    print(f"  - {{anchor: v2, routes: {{v1: {V1}}}}}")
    print(f"  - {{anchor: v1, routes: {{v2: {V2}}}}}")
