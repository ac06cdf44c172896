#!/usr/bin/env python3
"""Draws docs/reference/figures/setting-*.svg: what each machine setting does to both flanks of a tooth.

    python3 tools/draw_machine_settings.py [folder]

Needs nothing but Python. The deviations follow from the definitions in docs/reference/machine-settings.md for the gear named below; they share no
code with the service. The same command makes the same bytes.
"""
import sys
from math import acos, asin, atan, cos, pi, radians, sin, sqrt, tan
from pathlib import Path

# z 26, m_n 2.5 mm, 20 degrees, 24 degrees right hand, x 0.1, b 24 mm
Z, MN, AN, BETA, HAND, X, B = 26, 2.5, radians(20), radians(24), 1, 0.1, 24.0
AT = atan(tan(AN) / cos(BETA))
R = Z * MN / cos(BETA) / 2
RB = R * cos(AT)
BB = asin(sin(BETA) * cos(AN))
PSI = (pi / 2 + 2 * X * tan(AN)) / Z
PSI_B = PSI + tan(AT) - AT
L0 = RB * tan(AT)
L1, L2 = (sqrt((R + d) ** 2 - RB**2) for d in (-2.0, 2.6))
MINUTE = pi / 10800

LEFT, RIGHT = 1, -1
BLUE, GREY, GREEN, RED, INK = "#1f5fa8", "#9aa0a6", "#bfe3c0", "#f4c2bd", "#222222"
LINES = {0.0: "#d07a00", 0.5: "#222222", 1.0: "#1f5fa8"}


def point(side, length):
    """Point and transverse normal (out of the material) of the tooth at the top, in the section z = 0."""
    xi = length / RB
    phi = xi - PSI_B
    x, y = RB * (sin(phi) - xi * cos(phi)), RB * (cos(phi) + xi * sin(phi))
    return (side * x, y), (-side * cos(phi), sin(phi))


def u(length):
    return (2 * length - L1 - L2) / (L2 - L1)


def v(z):
    return 2 * z / B


def gap_moved(side, length, x, y):
    a = side * pi / Z
    mx, my = cos(a) * x - sin(a) * y, sin(a) * x + cos(a) * y
    _, (nx, ny) = point(side, length)
    return cos(BB) * (mx * nx + my * ny)


def profile_angle(side, length, z):
    slope = tan(AT) * cos(AT) ** 2 / (cos(BETA) * cos(AN) ** 2)
    return 1e3 * MINUTE * cos(BB) * (2 * X * RB / (Z * cos(AN) ** 2) - slope * (length - L0))


def worm(side, length, z):
    return z + side * HAND * (length - L0) * tan(BB)


# name, machine, amount with unit, deviation in µm for one unit, what the machine does, arrow in the gap left of the tooth
SETTINGS = [
    ("profile_angle", "", 8, "′", profile_angle, "greater normal pressure angle of the tool", None),
    ("helix_angle", "", 1.5, "′", lambda s, l, z: 1e3 * MINUTE * s * z * cos(AN) / cos(BETA),
     "signed helix angle grows: towards the right hand", None),
    ("profile_crowning", "", 10, " µm", lambda s, l, z: -u(l) ** 2, "more removed at root and tip", None),
    ("helix_crowning", "generating", 6, " µm", lambda s, l, z: -v(worm(s, l, z)) ** 2,
     "worm nearer to the axis towards both ends", None),
    ("helix_crowning", "form", 6, " µm", lambda s, l, z: -v(z) ** 2, "wheel path crowned towards both ends", None),
    ("twist", "generating", 40, " µm", lambda s, l, z: u(l) * v(z) / 4, "worm shifted along a dressed profile", None),
    ("tooth_thickness", "", 20, " µm", lambda s, l, z: 0.5 * cos(AN), "thicker tooth, both flanks alike", None),
    ("infeed", "form", 25, " µm", lambda s, l, z: gap_moved(s, l, 0, 1), "wheel away from the gear's axis", (0, 1)),
    ("tool_axis_offset", "generating", 10, " µm", lambda s, l, z: s * cos(AN), "worm to the left in the gap (−x)", (-1, 0)),
    ("tool_axis_offset", "form", 10, " µm", lambda s, l, z: gap_moved(s, l, -1, 0), "wheel to the left in the gap (−x)", (-1, 0)),
]


def steps(low, high, count=40):
    return [low + (high - low) * i / count for i in range(count + 1)]


def path(points, close=False):
    return "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in points) + ("Z" if close else "")


class Drawing:
    def __init__(self, width, height, title):
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
            f'font-family="Helvetica, Arial, sans-serif" font-size="12" role="img"><title>{title}</title>',
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        ]

    def line(self, points, color=INK, width=1.2, dash=""):
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<path d="{path(points)}" fill="none" stroke="{color}" stroke-width="{width}"{dash}/>')

    def fill(self, points, color):
        self.parts.append(f'<path d="{path(points, True)}" fill="{color}"/>')

    def text(self, x, y, text, anchor="middle", size=12, color=INK, bold=False):
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" fill="{color}"{weight}>{text}</text>')

    def arrow(self, x, y, dx, dy, color=BLUE):
        tip = (x + dx, y + dy)
        n = sqrt(dx * dx + dy * dy)
        ux, uy = dx / n, dy / n
        self.line([(x, y), tip], color, 2.5)
        self.fill([(tip[0] + 6 * ux, tip[1] + 6 * uy), (tip[0] - 5 * uy, tip[1] + 5 * ux), (tip[0] + 5 * uy, tip[1] - 5 * ux)], color)

    def between(self, nominal, changed, outward):
        """Green where the changed line stands out, red where it lies inside."""
        for (a, b, o), (c, d, p) in zip(zip(nominal, changed, outward), zip(nominal[1:], changed[1:], outward[1:])):
            self.fill([a, b, d, c], GREEN if o + p > 0 else RED)

    def end(self):
        return "\n".join(self.parts + ["</svg>", ""])


def section(d, deviation, x0, y0, arrow):
    """The tooth in the section of the middle of the face width, deviations 60 times too large."""
    scale, exaggerated = 19.0, 0.06
    place = lambda p: (x0 + scale * p[0], y0 - scale * (p[1] - (R - 2.3)))
    ends = []
    for side in (LEFT, RIGHT):
        lengths = steps(L1, L2)
        nominal, changed, out = [], [], []
        for length in lengths:
            (x, y), (nx, ny) = point(side, length)
            by = exaggerated * deviation(side, length, 0.0)
            nominal.append(place((x, y)))
            changed.append(place((x + by * nx, y + by * ny)))
            out.append(by)
        d.between(nominal, changed, out)
        d.line(nominal, GREY, 1.4, "5 3")
        d.line(changed, BLUE, 2)
        ends.append((nominal[0], nominal[-1]))
    d.line([ends[0][1], ends[1][1]], GREY, 1.2)
    for k, (foot, _) in enumerate(ends):
        d.line([foot, (foot[0] + (-16, 16)[k], foot[1] + 8)], GREY, 1.2)
    if arrow:
        centre = (ends[0][0][0] - 30, ends[0][0][1] - 60)
        d.arrow(*centre, 26 * arrow[0], -26 * arrow[1])
    d.text(x0 - 58, y0 - 92, "left", "end")
    d.text(x0 + 58, y0 - 92, "right", "start")
    d.text(x0, y0 + 30, "section in the middle", size=11, color="#555555")


def unrolled(d, deviation, x0, y0):
    """The tooth on the unrolled reference cylinder, seen from outside; z grows downwards, towards who looks at the section."""
    scale, along, exaggerated = 17.0, 6.4, 0.06
    for side in (LEFT, RIGHT):
        nominal, changed, out = [], [], []
        for z in steps(-B / 2, B / 2):
            # a right-hand helix turns counterclockwise, to the left of the viewer, on its way to the viewer
            x = -side * R * PSI - HAND * z * tan(BETA) * 0.35
            by = exaggerated * deviation(side, L0, z)
            nominal.append((x0 + scale * x, y0 + along * z))
            changed.append((x0 + scale * (x - side * by), y0 + along * z))
            out.append(by)
        d.between(nominal, changed, out)
        d.line(nominal, GREY, 1.4, "5 3")
        d.line(changed, BLUE, 2)
    d.text(x0, y0 - along * B / 2 - 8, "z = −b/2", size=11, color="#555555")
    d.text(x0, y0 + along * B / 2 + 16, "z = +b/2", size=11, color="#555555")
    d.text(x0, y0 + along * B / 2 + 32, "unrolled, seen from outside", size=11, color="#555555")


def chart(d, x0, y0, width, height, title, of, ends, colors, limit=14.0):
    d.line([(x0, y0), (x0 + width, y0)], "#bbbbbb", 1)
    d.line([(x0, y0 - height / 2), (x0, y0 + height / 2)], "#bbbbbb", 1)
    for tick in (-10, 10):
        y = y0 - tick / limit * height / 2
        d.line([(x0 - 3, y), (x0 + width, y)], "#eeeeee", 1)
        d.text(x0 - 6, y + 4, f"{tick:+d}".replace("-", "−"), "end", 10, "#555555")
    for value, color in colors.items():
        points = []
        for t in steps(0, 1):
            y = max(-limit, min(limit, of(t, value)))
            points.append((x0 + width * t, y0 - y / limit * height / 2))
        d.line(points, color, 2 if value == 0.5 else 1.6)
    d.text(x0 + width / 2, y0 - height / 2 - 4, title, size=11, bold=True)
    d.text(x0, y0 + height / 2 + 11, ends[0], "start", 10, "#555555")
    d.text(x0 + width, y0 + height / 2 + 11, ends[1], "end", 10, "#555555")


def draw(name, machine, amount, unit, of, action, arrow):
    deviation = lambda side, length, z: amount * of(side, length, z)
    label = f"{name} +{amount:g}{unit}" + (f", {machine} grinding" if machine else "")
    d = Drawing(900, 330, label)
    d.text(16, 24, label, "start", 15, bold=True)
    d.text(16, 42, action, "start", 12, "#555555")
    section(d, deviation, 150, 250, arrow)
    unrolled(d, deviation, 350, 170)
    at = lambda low, high, t: low + (high - low) * t
    for column, side in enumerate((LEFT, RIGHT)):
        x0, word = 478 + 215 * column, ("left", "right")[column]
        chart(d, x0, 100, 165, 84, f"profile, {word} flank", lambda t, s: deviation(side, at(L1, L2, t), at(-B / 2, B / 2, s)), ("root", "tip"), LINES)
        chart(d, x0, 228, 165, 84, f"helix, {word} flank", lambda t, s: deviation(side, at(L1, L2, s), at(-B / 2, B / 2, t)), ("z = −b/2", "+b/2"), LINES)
    for k, (value, words) in enumerate(((0.0, "at −b/2, root"), (0.5, "in the middle"), (1.0, "at +b/2, tip"))):
        x = 480 + 135 * k
        d.line([(x, 306), (x + 22, 306)], LINES[value], 2)
        d.text(x + 28, 310, words, "start", 11)
    d.text(884, 24, "µm, + = material left standing", "end", 11, "#555555")
    d.text(16, 318, "dashed: nominal; green: material left, red: material removed", "start", 11, "#555555")
    return d.end()


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent / "docs" / "reference" / "figures")
    for setting in SETTINGS:
        name, machine = setting[0].replace("_", "-"), setting[1]
        file = folder / f"setting-{name}{'-' + machine if machine else ''}.svg"
        file.write_text(draw(*setting), encoding="utf-8")
        print(file.name)


if __name__ == "__main__":
    main()
