#!/usr/bin/env python3
"""Opens exported IGES and STEP files with OpenCASCADE and compares what it finds with what should be there.

For every NAME.json in a folder (written by `cargo run -p engine-benches --example export_cad -- FOLDER`) the files NAME.igs and NAME.stp
beside it are read. The JSON lists the shapes in the order of the file: kind ("curve" or "surface"), name, parameters and the
places there. Every shape must be read as one B-spline, give the same places at the same parameters, have its name, and faces
must be valid shapes for the kernel. Exit status 1 if anything differs.

Usage: check_cad.py FOLDER [--tolerance 1e-12]
"""

import argparse
import json
import sys
from pathlib import Path

from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface
from OCP.gp import gp_Pnt
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_Gravity
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS


class Wrong(Exception):
    """The file does not hold what it should."""


def opened(path):
    """A reader that has taken up the file without a complaint."""
    reader = IGESControl_Reader() if path.suffix == ".igs" else STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise Wrong("cannot be read")
    # Curves stay as they are, also where they are only continuous.
    Interface_Static.SetIVal_s("read.iges.bspline.continuity", 0)
    against = list(complaints(reader))
    if against:
        raise Wrong("; ".join(against))
    reader.TransferRoots()
    return reader


def complaints(reader):
    """What the reader says against form and meaning of the file before it turns it into shapes."""
    checks = reader.WS().ModelCheckList()
    checks.Start()
    while checks.More():
        check = checks.Value()
        yield from (check.CFail(i) for i in range(1, check.NbFails() + 1))
        yield from (check.CWarning(i) for i in range(1, check.NbWarnings() + 1))
        checks.Next()


def explored(shape, kind, outside=TopAbs_ShapeEnum.TopAbs_SHAPE):
    explorer = TopExp_Explorer(shape, kind, outside)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def name_of(reader, shape):
    """The name that the file gives to the entity behind a face or edge."""
    entity = reader.WS().TransferReader().EntityFromShapeResult(shape, -1)
    if hasattr(entity, "HasName"):
        return entity.NameValue().ToCString() if entity.HasName() and entity.NameValue() else ""
    return entity.Name().ToCString()


def geometry(reader):
    """The B-spline surfaces and the free B-spline curves of a file, in its order, with their names."""
    surfaces, curves = [], []
    for i in range(1, reader.NbShapes() + 1):
        shape = reader.Shape(i)
        for face in explored(shape, TopAbs_ShapeEnum.TopAbs_FACE):
            if not BRepCheck_Analyzer(face).IsValid():
                raise Wrong("a face is not valid")
            surfaces.append((name_of(reader, face), BRep_Tool.Surface_s(TopoDS.Face(face))))
        for edge in explored(shape, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_FACE):
            curves.append((name_of(reader, edge), BRep_Tool.Curve_s(TopoDS.Edge(edge), 0.0, 1.0)))
    return {"surface": surfaces, "curve": curves}


def greatest_gap(found, wanted):
    """The greatest distance between what was found and what was wanted, as a share of the greatest coordinate."""
    spline = Geom_BSplineCurve if wanted["kind"] == "curve" else Geom_BSplineSurface
    if not isinstance(found, spline):
        raise Wrong(f"{wanted['name']!r} came back as {type(found).__name__}")
    size = max(abs(x) for place in wanted["points"] for x in place)
    gap = 0.0
    for at, place in zip(wanted["at"], wanted["points"]):
        here = gp_Pnt()
        if wanted["kind"] == "curve":
            found.D0(at, here)
        else:
            found.D0(at[0], at[1], here)
        gap = max(gap, *(abs(a - b) for a, b in zip((here.X(), here.Y(), here.Z()), place)))
    return gap / size


def check(path, wanted, tolerance):
    found = geometry(opened(path))
    for kind, shapes in found.items():
        count = sum(shape["kind"] == kind for shape in wanted)
        if len(shapes) != count:
            raise Wrong(f"{len(shapes)} shapes of the kind {kind}, {count} were written")
    worst = 0.0
    for shape in wanted:
        name, geometric = found[shape["kind"]].pop(0)
        # IGES knows ASCII only
        known = shape["name"].encode("ascii", "replace").decode() if path.suffix == ".igs" else shape["name"]
        if name != known:
            raise Wrong(f"{shape['name']!r} is named {name!r}")
        gap = greatest_gap(geometric, shape)
        if not gap <= tolerance:
            raise Wrong(f"{shape['name']!r} is off by {gap:.2e} of its size")
        worst = max(worst, gap)
    return worst


def silence():
    """Leaves only serious messages of the kernel on the terminal."""
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Alarm)


def main():
    parser = argparse.ArgumentParser(description="Compare exported CAD files with what they should hold.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tolerance", type=float, default=1e-12, help="relative to the size of a shape")
    options = parser.parse_args()
    silence()
    cases = sorted(options.folder.glob("*.json"))
    wrong = 0 if cases else 1
    for case in cases:
        wanted = json.loads(case.read_text())
        for suffix in (".igs", ".stp"):
            path = case.with_suffix(suffix)
            try:
                places = sum(len(shape["at"]) for shape in wanted)
                worst = check(path, wanted, options.tolerance)
                print(f"{path.name:28} {len(wanted)} shapes, {places:5} places, greatest deviation {worst:.1e}")
            except Wrong as fault:
                wrong += 1
                print(f"{path.name:28} WRONG: {fault}")
    if not cases:
        print(f"there is no JSON file in {options.folder}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
