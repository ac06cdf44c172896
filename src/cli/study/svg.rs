//! A small writer of SVG figures: two panels side by side, a curve with its quartiles over a
//! logarithmic axis, and horizontal lines to compare with. Coordinates have two decimals, so that
//! equal studies give equal bytes.

use std::fmt::Write;

/// Points `[log₁₀ k, lower quartile, median, upper quartile]`, ascending.
pub struct Curve {
    pub points: Vec<[f64; 4]>,
}

/// A horizontal line.
pub struct Line {
    pub name: String,
    pub at: f64,
}

pub struct Panel {
    pub title: String,
    pub curve: Curve,
    pub lines: Vec<Line>,
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 58.0;
const TOP: f64 = 52.0;
const GAP: f64 = 76.0;
/// Told apart also without colours, by their dashes.
const STROKES: [(&str, &str); 4] =
    [("#444444", "none"), ("#b2452b", "7 3"), ("#2b7a4b", "2 3"), ("#7a4ba8", "9 3 2 3")];

/// A figure of two panels.
pub fn page(title: &str, panels: &[Panel; 2]) -> String {
    let (width, height) = (LEFT + 2.0 * WIDTH + GAP + 16.0, TOP + HEIGHT + 84.0);
    let mut out = String::new();
    // writing to a string cannot fail
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" \
         font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{LEFT:.0}\" y=\"20\" font-size=\"15\">{}</text>",
        escape(title)
    );
    for (i, panel) in panels.iter().enumerate() {
        draw(&mut out, panel, LEFT + i as f64 * (WIDTH + GAP));
    }
    legend(&mut out, &panels[0].lines, TOP + HEIGHT + 62.0);
    out.push_str("</svg>\n");
    out
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Ends of an axis and the distance of its ticks: 1, 2 or 5 times a power of ten, at most eight of
/// them.
fn ticks(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        (low, high) = (low.min(value), high.max(value));
    }
    if !(low <= high) {
        return [0.0, 1.0, 1.0];
    }
    let span = (high - low).max(1e-3);
    let power = 10f64.powi(libm::log10(span / 8.0).floor() as i32);
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| span / s <= 8.0).unwrap_or(span);
    [(low / step).floor() * step, (high / step).ceil() * step, step]
}

fn draw(out: &mut String, panel: &Panel, left: f64) {
    let points = &panel.curve.points;
    let heights = points.iter().flat_map(|p| p[1..].iter().copied()).chain(panel.lines.iter().map(|line| line.at));
    let [bottom, top, step] = ticks(heights);
    let [first, last, decade] = ticks(points.iter().map(|p| p[0]));
    let x = |value: f64| left + WIDTH * (value - first) / (last - first);
    let y = |value: f64| TOP + HEIGHT * (top - value) / (top - bottom);
    let _ = writeln!(
        out,
        "<text x=\"{left:.2}\" y=\"42\">{}</text>\n\
         <rect x=\"{left:.2}\" y=\"{TOP:.2}\" width=\"{WIDTH:.2}\" height=\"{HEIGHT:.2}\" fill=\"none\" \
         stroke=\"#888888\"/>",
        escape(&panel.title)
    );
    for i in 0..=((top - bottom) / step).round() as usize {
        let value = bottom + i as f64 * step;
        let at = y(value);
        let _ = writeln!(
            out,
            "<path d=\"M{left:.2} {at:.2}h{WIDTH:.2}\" stroke=\"#e4e4e4\"/>\
             <text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"end\">{}</text>",
            left - 6.0,
            at + 4.0,
            label(value, step)
        );
    }
    for i in 0..=((last - first) / decade).round() as usize {
        let value = first + i as f64 * decade;
        let at = x(value);
        let _ = writeln!(
            out,
            "<path d=\"M{at:.2} {TOP:.2}v{HEIGHT:.2}\" stroke=\"#e4e4e4\"/>\
             <text x=\"{at:.2}\" y=\"{:.2}\" text-anchor=\"middle\">{}</text>",
            TOP + HEIGHT + 17.0,
            label(value, decade)
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"middle\">log₁₀ k, k = σ_noise/σ_signal</text>",
        left + WIDTH / 2.0,
        TOP + HEIGHT + 36.0
    );
    for (line, (colour, dashes)) in panel.lines.iter().zip(STROKES) {
        let _ = writeln!(
            out,
            "<path d=\"M{left:.2} {:.2}h{WIDTH:.2}\" stroke=\"{colour}\" stroke-width=\"1.5\" \
             stroke-dasharray=\"{dashes}\"/>",
            y(line.at)
        );
    }
    let path = |column: usize, reverse: bool| {
        let place = |p: &[f64; 4]| format!("{:.2} {:.2}", x(p[0]), y(p[column]));
        let mut places: Vec<String> = points.iter().map(place).collect();
        if reverse {
            places.reverse();
        }
        places.join("L")
    };
    if !points.is_empty() {
        let _ = writeln!(
            out,
            "<path d=\"M{}L{}Z\" fill=\"#2b62b2\" fill-opacity=\"0.2\"/>\n\
             <path d=\"M{}\" fill=\"none\" stroke=\"#2b62b2\" stroke-width=\"2\"/>",
            path(1, false),
            path(3, true),
            path(2, false)
        );
    }
}

/// A tick's number with as many decimals as its step asks for; a typographic minus.
fn label(value: f64, step: f64) -> String {
    let decimals = (-libm::log10(step).floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{:.decimals$}", if value.abs() < 1e-9 * step { 0.0 } else { value });
    text.replace('-', "−")
}

fn legend(out: &mut String, lines: &[Line], at: f64) {
    let mut left = LEFT;
    let mut entry = |name: &str, colour: &str, dashes: &str, width: f64| {
        let _ = writeln!(
            out,
            "<path d=\"M{left:.2} {:.2}h28\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-dasharray=\"{dashes}\"/>\
             <text x=\"{:.2}\" y=\"{at:.2}\">{}</text>",
            at - 4.0,
            left + 34.0,
            escape(name)
        );
        left += 58.0 + 6.6 * name.chars().count() as f64;
    };
    entry("randomised, median and quartiles", "#2b62b2", "none", 2.0);
    for (line, (colour, dashes)) in lines.iter().zip(STROKES) {
        entry(&line.name, colour, dashes, 1.5);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_hold_everything() {
        assert_eq!(ticks([-4.0, 0.0].into_iter()), [-4.0, 0.0, 0.5]);
        assert_eq!(ticks([3.1, 17.2].into_iter()), [2.0, 18.0, 2.0]);
        assert_eq!(ticks(std::iter::empty()), [0.0, 1.0, 1.0]);
        let [low, high, step] = ticks([2.0, 2.0].into_iter());
        assert!(low <= 2.0 && high >= 2.0 && step > 0.0);
    }

    #[test]
    fn a_figure_without_points_is_still_a_figure() {
        let panel = || Panel { title: "a < b".into(), curve: Curve { points: Vec::new() }, lines: Vec::new() };
        let text = page("&", &[panel(), panel()]);
        assert!(text.starts_with("<svg") && text.ends_with("</svg>\n"));
        assert!(text.contains("a &lt; b") && text.contains("&amp;") && !text.contains("NaN") && !text.contains("inf"));
    }
}
