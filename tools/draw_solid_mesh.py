#!/usr/bin/env python3
"""Draws a solid mesh of a gear: the outer faces of an MSH 2.2 file, coloured by their sets, as SVG.

    draw_solid_mesh.py MESH.msh PICTURE.svg

Standard library only. The file is that of `POST /v1/gears/solid-mesh` with `"format": "gmsh"`.
"""

import math
import sys

COLOURS = {
    "LEFT_FLANK": "#4f86c6",
    "RIGHT_FLANK": "#6fa8dc",
    "ROOT": "#e0a458",
    "TIP": "#9aa5b1",
    "BORE": "#7fb685",
    "RIM": "#7fb685",
    "CUT": "#d7dbe0",
    "END": "#eceff3",
}
# where the viewer stands: right of, above and before the sector
VIEW = (0.55, 0.42, 0.72)
LIGHT = (0.2, 0.75, 0.63)
WIDTH = 900


def read(path):
    """Nodes, and for each named set its faces (corners only)."""
    with open(path, encoding="ascii") as file:
        lines = iter(file.read().splitlines())
    names, nodes, faces = {}, {}, []
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                _, tag, name = next(lines).split()
                names[int(tag)] = name.strip('"')
        elif line == "$Nodes":
            for _ in range(int(next(lines))):
                number, x, y, z = next(lines).split()
                nodes[int(number)] = (float(x), float(y), float(z))
        elif line == "$Elements":
            for _ in range(int(next(lines))):
                _, kind, _, group, _, *of = map(int, next(lines).split())
                if kind in (3, 16):
                    faces.append((names[group], outline(of)))
    return nodes, faces


def outline(of):
    """The nodes around a face: corners, and the middles of edges between them."""
    if len(of) == 4:
        return of
    return [node for pair in zip(of[:4], of[4:]) for node in pair]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def shaded(colour, light):
    parts = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{round(min(255, part * light)):02x}" for part in parts)


def main(mesh, picture):
    nodes, faces = read(mesh)
    toward = unit(VIEW)
    right = unit(cross((0, 1, 0), toward))
    up = cross(toward, right)
    drawn = []
    for name, around in faces:
        points = [nodes[node] for node in around]
        a, b, c = points[0], points[len(points) // 4], points[-len(points) // 4]
        normal = unit(cross([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]))
        if dot(normal, toward) <= 0:
            continue
        depth = max(dot(point, toward) for point in points)
        middle = sum(dot(point, toward) for point in points) / len(points)
        flat = [(dot(point, right), -dot(point, up)) for point in points]
        base = next(colour for key, colour in COLOURS.items() if name.startswith(key))
        light = 0.72 + 0.3 * max(0.0, dot(normal, unit(LIGHT)))
        drawn.append(((middle, depth), flat, shaded(base, light)))
    drawn.sort(key=lambda face: face[0])
    xs = [x for _, flat, _ in drawn for x, _ in flat]
    ys = [y for _, flat, _ in drawn for _, y in flat]
    scale = (WIDTH - 20) / (max(xs) - min(xs))
    height = round((max(ys) - min(ys)) * scale) + 20
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" stroke="#39424e" '
           'stroke-width="0.6" stroke-linejoin="round">']
    for _, flat, colour in drawn:
        at = " ".join(f"{10 + (x - min(xs)) * scale:.1f},{10 + (y - min(ys)) * scale:.1f}" for x, y in flat)
        out.append(f'<polygon points="{at}" fill="{colour}"/>')
    out.append("</svg>")
    with open(picture, "w", encoding="ascii") as file:
        file.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
