//! Makes `flank_z52.json`, `flank_z52_right.json` and both flanks `…_remachined.json`: the nodes
//! that `flankfit demo` posts.
//!
//! A spur gear of 52 teeth, m_n = 1 mm, α = 20°, x = 0.011, b = 15 mm is "measured" on a grid of
//! roll length `L = √(r² − r_b²)` (mm, over the evaluation range from d = 50.3 mm to 54.022 mm) and
//! face width (mm, 0.75 to 14.25). Heights are deviations in µm, material missing negative. With s
//! and t the two axes mapped to [-1, 1],
//!
//! `z(s, t) = −C_α s² − C_β t² + f_Hα/2 · s + S/4 · s t + probe noise`.
//!
//! The first grids carry profile slopes of 9 and 8.4 µm. On the remachined ones the pressure angle,
//! which turns both flanks alike, has been corrected: less than a micrometre of slope is left, and
//! everything else is as it was. Nothing here depends on a library's random numbers: the same
//! program always makes the same files.
//!
//! Run: `cargo run --example make_flank_grid -- examples` (the argument is the folder to write to).

use std::{fmt::Write as _, io, path::Path};

/// Gear: number of teeth × m_n × cos α_n / 2, in mm.
const TEETH: f64 = 52.0;
const NORMAL_MODULE_MM: f64 = 1.0;
const PRESSURE_ANGLE_DEG: f64 = 20.0;

/// Where profile and helix are evaluated.
const PROFILE_DIAMETERS_MM: [f64; 2] = [50.3, 54.022];
const HELIX_RANGE_MM: [f64; 2] = [0.75, 14.25];

/// Nodes along the profile and along the face.
const PROFILE_NODES: usize = 9;
const HELIX_NODES: usize = 15;

/// One standard deviation of a probed height, µm.
const PROBE_NOISE_UM: f64 = 0.5;

/// Nodes that the probe did not reach (row along the profile, column along the face).
const MISSING: [(usize, usize); 3] = [(0, 0), (3, 10), (8, 14)];

/// What distinguishes one measured flank from another.
pub struct Flank {
    pub file: &'static str,
    pub side: &'static str,
    pub profile_crowning_um: f64,
    pub helix_crowning_um: f64,
    pub profile_slope_um: f64,
    pub twist_um: f64,
    pub seed: u64,
}

/// The flank as first ground, and after the correction.
pub const FLANKS: [Flank; 4] = [
    Flank {
        file: "flank_z52.json",
        side: "left",
        profile_crowning_um: 3.0,
        helix_crowning_um: 4.0,
        profile_slope_um: 9.0,
        twist_um: 3.0,
        seed: 52,
    },
    Flank {
        file: "flank_z52_remachined.json",
        side: "left",
        profile_crowning_um: 3.0,
        helix_crowning_um: 4.0,
        profile_slope_um: 0.5,
        twist_um: 3.0,
        seed: 53,
    },
    Flank {
        file: "flank_z52_right.json",
        side: "right",
        profile_crowning_um: 3.4,
        helix_crowning_um: 4.4,
        profile_slope_um: 8.4,
        twist_um: 1.5,
        seed: 54,
    },
    Flank {
        file: "flank_z52_right_remachined.json",
        side: "right",
        profile_crowning_um: 3.4,
        helix_crowning_um: 4.4,
        profile_slope_um: -0.1,
        twist_um: 1.5,
        seed: 55,
    },
];

/// The whole fit request, ready to be posted.
pub fn fit_request(flank: &Flank) -> String {
    let u = axis(roll_length_mm(PROFILE_DIAMETERS_MM[0]), roll_length_mm(PROFILE_DIAMETERS_MM[1]), PROFILE_NODES);
    let v = axis(HELIX_RANGE_MM[0], HELIX_RANGE_MM[1], HELIX_NODES);
    let mut noise = Noise(flank.seed);
    let rows: Vec<String> = (0..PROFILE_NODES)
        .map(|i| {
            let row: Vec<String> = (0..HELIX_NODES)
                .map(|j| {
                    let z = deviation_um(flank, mapped(i, PROFILE_NODES), mapped(j, HELIX_NODES))
                        + PROBE_NOISE_UM * noise.normal();
                    if MISSING.contains(&(i, j)) { "null".to_owned() } else { format!("{z:.2}") }
                })
                .collect();
            format!("      [{}]", row.join(", "))
        })
        .collect();
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        r#"{{
  "nodes": {{
    "type": "grid",
    "u": [{}],
    "v": [{}],
    "z": [
{}
    ]
  }},
  "flank": "{}",
  "tooth": "1",
  "axes": {{
    "u": {{"quantity": "roll_length", "unit": "mm"}},
    "v": {{"quantity": "face_width", "unit": "mm"}},
    "z": {{"quantity": "deviation", "unit": "um", "positive": "material_out"}}
  }},
  "model": {{"type": "polynomial", "degree": [2, 2], "basis": "monomial", "terms": "tensor"}},
  "regularization": {{
    "type": "spectral",
    "scheme": "first_order",
    "count": "auto",
    "lambda_star": {{"criterion": "min_mse"}}
  }},
  "include": ["residuals", "collinearity"]
}}
"#,
        u.join(", "),
        v.join(", "),
        rows.join(",\n"),
        flank.side
    );
    text
}

/// Deviation without noise; s and t in [-1, 1].
fn deviation_um(flank: &Flank, s: f64, t: f64) -> f64 {
    -flank.profile_crowning_um * s * s - flank.helix_crowning_um * t * t
        + flank.profile_slope_um / 2.0 * s
        + flank.twist_um / 4.0 * s * t
}

fn roll_length_mm(diameter_mm: f64) -> f64 {
    let base_radius = TEETH * NORMAL_MODULE_MM * PRESSURE_ANGLE_DEG.to_radians().cos() / 2.0;
    (diameter_mm * diameter_mm / 4.0 - base_radius * base_radius).sqrt()
}

/// Equal steps, to a tenth of a micrometre, as a measuring machine writes them.
fn axis(from: f64, to: f64, nodes: usize) -> Vec<String> {
    (0..nodes).map(|i| format!("{:.4}", from + (to - from) * i as f64 / (nodes - 1) as f64)).collect()
}

fn mapped(i: usize, nodes: usize) -> f64 {
    2.0 * i as f64 / (nodes - 1) as f64 - 1.0
}

/// Pseudo-random numbers: splitmix64, and the sum of twelve uniform numbers for a normal one
/// (variance exactly 1, additions only, hence the same on every machine; tails end at 6 σ).
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^= x >> 31;
        (x >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn main() -> io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "examples".to_owned());
    for flank in &FLANKS {
        let path = Path::new(&folder).join(flank.file);
        std::fs::write(&path, fit_request(flank))?;
        println!("wrote {}", path.display());
    }
    Ok(())
}
