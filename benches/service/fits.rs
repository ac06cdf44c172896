//! `POST /v1/fits`: eight keep-alive connections, full diagnostics in every answer.

use divan::{Bencher, counter::ItemsCount};
use serde_json::{Value, json};

use load::{Press, Server, post};

const CONNECTIONS: usize = 8;
/// Requests of a round, so many that its beginning and end do not count.
const ROUND: usize = 800;

/// 45, 1,000 and 10,000 nodes, degree (3,3).
const SHAPES: [(usize, usize); 3] = [(5, 9), (25, 40), (100, 100)];

#[divan::bench(args = SHAPES, sample_size = 1, max_time = 5)]
fn grids(bencher: Bencher, (nu, nv): (usize, usize)) {
    rounds(bencher, &grid(nu, nv, 3));
}

#[divan::bench(args = [SHAPES[2]], sample_size = 1, max_time = 5)]
fn scattered_nodes(bencher: Bencher, (nu, nv): (usize, usize)) {
    rounds(bencher, &scattered(nu, nv, 3));
}

fn rounds(bencher: Bencher, body: &Value) {
    let server = Server::start(env!("CARGO_TARGET_TMPDIR"));
    let request = post("/v1/fits", &body.to_string());
    let (status, answer) = load::once(server.address, &request);
    assert_eq!(status, 200, "{}", String::from_utf8_lossy(&answer));
    let mut press = Press::new(server.address, CONNECTIONS);
    bencher.counter(ItemsCount::new(ROUND)).bench_local(|| press.round(&request, ROUND));
}

/// A request with the defaults of the contract.
fn request(nodes: Value, degree: usize) -> Value {
    json!({"nodes": nodes, "model": {"type": "polynomial", "degree": [degree, degree]}})
}

/// Numbers as a measuring machine writes them, to 0.1 µm in position and 1 nm in height.
fn rounded(x: f64, places: i32) -> f64 {
    let unit = 10_f64.powi(places);
    (x * unit).round() / unit
}

fn axis(from: f64, to: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| rounded(from + (to - from) * i as f64 / (n - 1) as f64, 4)).collect()
}

fn height(u: f64, v: f64) -> f64 {
    let (s, t) = ((u - 8.745) / 2.775, (v - 7.5) / 6.75);
    rounded(4.5 * s - 3.0 * s * s - 4.0 * t * t + 0.75 * s * t + 0.3 * (37.0 * u + 19.0 * v).sin(), 3)
}

fn grid(nu: usize, nv: usize, degree: usize) -> Value {
    let (u, v) = (axis(5.97, 11.52, nu), axis(0.75, 14.25, nv));
    let z: Vec<Vec<f64>> = u.iter().map(|&u| v.iter().map(|&v| height(u, v)).collect()).collect();
    request(json!({"type": "grid", "u": u, "v": v, "z": z}), degree)
}

fn scattered(nu: usize, nv: usize, degree: usize) -> Value {
    let (mut us, mut vs, mut zs) = (Vec::new(), Vec::new(), Vec::new());
    for (i, u) in axis(5.97, 11.52, nu).into_iter().enumerate() {
        for (j, v) in axis(0.75, 14.25, nv).into_iter().enumerate() {
            let u = rounded(u + 0.02 * (13.0 * i as f64 + 7.0 * j as f64).sin(), 4);
            let v = rounded(v + 0.05 * (5.0 * i as f64 - 11.0 * j as f64).cos(), 4);
            us.push(u);
            vs.push(v);
            zs.push(height(u, v));
        }
    }
    request(json!({"type": "scattered", "u": us, "v": vs, "z": zs}), degree)
}
