//! Roots of the secular equation `1 + Σ wⱼ/(dⱼ − λ) = 0`, one above each pole.
//!
//! A root is sought as its distance τ from the nearer pole, so that all differences `dⱼ − λ` keep
//! their digits; by the rational interpolation of Li ("middle way", LAPACK working note 89), in a
//! bracket.

/// Steps at most; four to six are usual.
const STEPS: usize = 100;

/// Sums of the secular equation at one place: over the poles up to the root, and over those above
/// it, each with its derivative.
struct Sums {
    before: [f64; 2],
    beyond: [f64; 2],
}

impl Sums {
    fn value(&self) -> f64 {
        1.0 + self.before[0] + self.beyond[0]
    }

    fn slope(&self) -> f64 {
        self.before[1] + self.beyond[1]
    }
}

/// `Σ wⱼ/(gapⱼ − τ)` with its derivative by τ.
fn sum(w: &[f64], gap: &[f64], tau: f64) -> [f64; 2] {
    let ((w4, w), (gap4, gap)) = (w.as_chunks::<4>(), gap.as_chunks::<4>());
    let (mut value, mut slope) = ([0.0; 4], [0.0; 4]);
    for (w, gap) in w4.iter().zip(gap4) {
        for k in 0..4 {
            let inverse = 1.0 / (gap[k] - tau);
            let term = w[k] * inverse;
            value[k] += term;
            slope[k] += term * inverse;
        }
    }
    for (w, gap) in w.iter().zip(gap) {
        let inverse = 1.0 / (gap - tau);
        let term = w * inverse;
        value[0] += term;
        slope[0] += term * inverse;
    }
    [(value[0] + value[1]) + (value[2] + value[3]), (slope[0] + slope[1]) + (slope[2] + slope[3])]
}

/// Root above pole `i` of ascending poles `d` with weights `w` > 0; `gap` takes `dⱼ − λ`.
pub(super) fn root(i: usize, d: &[f64], w: &[f64], gap: &mut [f64]) -> f64 {
    let k = d.len();
    let last = i + 1 == k;
    let width = if last { w.iter().sum::<f64>() } else { d[i + 1] - d[i] };
    let about = |origin: f64, gap: &mut [f64]| gap.iter_mut().zip(d).for_each(|(gap, d)| *gap = d - origin);
    let sums = |gap: &[f64], tau: f64| Sums {
        before: sum(&w[..=i], &gap[..=i], tau),
        beyond: sum(&w[i + 1..], &gap[i + 1..], tau),
    };
    about(d[i], gap);
    let middle = 0.5 * width;
    let left = sums(gap, middle).value() >= 0.0;
    let (origin, mut low, mut high, mut tau) = match (left, last) {
        (true, _) => (d[i], 0.0, middle, middle),
        (false, true) => (d[i], middle, width, middle),
        (false, false) => (d[i + 1], -middle, 0.0, -middle),
    };
    about(origin, gap);
    for _ in 0..STEPS {
        let here = sums(gap, tau);
        let f = here.value();
        let rounding = 8.0 * (here.beyond[0] - here.before[0]) + 1.0 + tau.abs() * here.slope();
        if f.abs() <= f64::EPSILON * rounding {
            break;
        }
        if f < 0.0 {
            low = tau
        } else {
            high = tau
        }
        if high - low <= 2.0 * f64::EPSILON * low.abs().max(high.abs()) {
            break;
        }
        let own = gap[i] - tau;
        // above the last pole there is none: one of weight 0 takes its place
        let next = if last { gap[i] + width - tau } else { gap[i + 1] - tau };
        let slope = here.slope();
        let a = (own + next) * f - own * next * slope;
        let b = own * next * f;
        let c = f - own * here.before[1] - next * here.beyond[1];
        let square = (a * a - 4.0 * b * c).abs().sqrt();
        let mut step = match c == 0.0 {
            true => b / a,
            false if a <= 0.0 => (a - square) / (2.0 * c),
            false => 2.0 * b / (a + square),
        };
        if !(f * step < 0.0) {
            step = -f / slope;
        }
        tau += step;
        if !(low < tau && tau < high) {
            tau = match () {
                () if low == 0.0 => high / 16.0,
                () if high == 0.0 => low / 16.0,
                () => 0.5 * (low + high),
            };
        }
    }
    gap.iter_mut().for_each(|gap| *gap -= tau);
    origin + tau
}
