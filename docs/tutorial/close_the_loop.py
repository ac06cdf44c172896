"""Closes the loop between measuring and grinding: measure, evaluate, correct, measure again, compare."""
import json, math, random, sys, urllib.request

BASE = sys.argv[1] if len(sys.argv) > 1 else "http://127.0.0.1:8080"


def call(method, path, body=None):
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(BASE + path, data, {"Content-Type": "application/json"}, method=method)
    with urllib.request.urlopen(request) as response:
        return json.load(response)


# The machine: a form grinder whose dressed profile and helix angle are off by some arc minutes.
GEAR = {"teeth": 52, "normal_module_mm": 1.0, "normal_pressure_angle_deg": 20.0, "helix_angle_deg": 0.0, "face_width_mm": 15.0}
ROLL = [6.0 + 0.69 * k for k in range(9)]      # mm, root to tip
FACE = [0.75 + 0.9643 * k for k in range(15)]  # mm
machine = {"profile_angle": -14.0, "helix_angle": 3.0}
noise = random.Random(52)


def measure():
    """The deviations of the left flank in µm along the normal: what the machine grinds, and 0.4 µm of noise."""
    profile = -0.106 * machine["profile_angle"]                                   # µm per mm of roll length
    helix = 0.2909 * math.cos(math.radians(20)) * machine["helix_angle"]          # µm per mm of face width
    height = lambda u, v: profile * (u - 8.76) + helix * (v - 7.5) - 3 * ((v - 7.5) / 6.75) ** 2
    return [[round(height(u, v) + noise.gauss(0, 0.4), 2) for v in FACE] for u in ROLL]


def iteration(note):
    """Stores one measurement with its fit, and prints the gear figures against their limits."""
    body = {"nodes": {"type": "grid", "u": ROLL, "v": FACE, "z": measure()}, "flank": "left", "tooth": "1", "note": note,
            "axes": {"u": {"quantity": "roll_length", "unit": "mm"}, "v": {"quantity": "face_width", "unit": "mm"},
                     "z": {"quantity": "deviation", "unit": "um", "positive": "material_out"}},
            "model": {"type": "polynomial", "degree": [2, 2], "basis": "legendre"}}
    stored = call("POST", f"/v1/jobs/{job}/iterations", body)
    print(f"\n{note} (iteration {stored['number']})")
    for name, figure in stored["fits"][0]["figures"].items():
        if isinstance(figure, dict) and "conformity" in figure:
            low, high = figure["conformity"]["limits_um"]
            print(f"  {name:22} {figure['value']:6.2f} ± {figure['std_error']:.2f}  [{low:.1f}, {high:.1f}]  {figure['conformity']['decision']}")
    return stored["number"]


limits = {"profile_slope_um": [-5, 5], "helix_slope_um": [-5, 5], "helix_crowning_um": [1, 6]}
job = call("POST", "/v1/jobs", {"name": "Tutorial", "gear": GEAR, "requirements": {"tolerance_limits": limits}})["id"]

first = iteration("First measurement")
correction = call("POST", f"/v1/jobs/{job}/iterations/{first}/correction",
                  {"sensitivity": {"machine": "form_grinding"}, "limits": {"profile_angle": {"increment": 0.05}, "helix_angle": {"increment": 0.01}}})
print("\nChanges of the machine")
for setting in correction["settings"]:
    if setting["change"]:
        print(f"  {setting['name']:22} {setting['change']:+.2f} {setting['unit']} ± {setting['std_error']:.2f}")
        if setting["name"] in machine:
            machine[setting["name"]] += setting["change"]

iteration("After the correction")
print("\n" + call("GET", f"/v1/jobs/{job}/iterations/{first}/correction")["answer"]["sentence"])
