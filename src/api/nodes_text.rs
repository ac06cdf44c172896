//! Nodes as they were posted, as JSON and as CSV.

use std::io::Write;

use crate::estimation::nodes::{Grid, Nodes};
use crate::numerics::cancel::Asking;

/// JSON in the contract's form; a missing node is `null`.
pub fn to_json(nodes: &Nodes) -> Vec<u8> {
    let mut out = Vec::with_capacity(64 + 24 * 3 * nodes.posted());
    match nodes {
        Nodes::Curve(c) => {
            out.extend_from_slice(br#"{"type":"curve","x":"#);
            array(&mut out, &c.x);
            field(&mut out, "y", &c.y);
            weight(&mut out, c.weight.as_deref(), None);
        }
        Nodes::Scattered(s) => {
            out.extend_from_slice(br#"{"type":"scattered","u":"#);
            array(&mut out, &s.u);
            field(&mut out, "v", &s.v);
            field(&mut out, "z", &s.z);
            weight(&mut out, s.weight.as_deref(), None);
        }
        Nodes::Grid(g) => {
            out.extend_from_slice(br#"{"type":"grid","u":"#);
            array(&mut out, &g.u);
            field(&mut out, "v", &g.v);
            out.extend_from_slice(br#","z":"#);
            rows(&mut out, &g.z, g.v.len(), number);
            if let Some(valid) = &g.valid {
                out.extend_from_slice(br#","valid":"#);
                rows(&mut out, valid, g.v.len(), |out, valid| {
                    out.extend_from_slice(if valid { b"true" } else { b"false" });
                });
            }
            weight(&mut out, g.weight.as_deref(), Some(g.v.len()));
        }
        Nodes::Matrix(m) => {
            out.extend_from_slice(br#"{"type":"matrix","x":"#);
            rows(&mut out, &m.x, m.columns, number);
            field(&mut out, "y", &m.y);
            if let Some(names) = &m.names {
                out.extend_from_slice(br#","names":"#);
                // Strings are always writable as JSON.
                let _written = serde_json::to_writer(&mut out, names);
            }
            weight(&mut out, m.weight.as_deref(), None);
        }
    }
    out.push(b'}');
    out
}

/// CSV with a header: `x,y`, `u,v,z` or the column names and `y`, then `weight` where there are weights. A missing
/// node has an empty height.
pub fn to_csv(nodes: &Nodes) -> Vec<u8> {
    let mut out = Vec::with_capacity(64 + 24 * 3 * nodes.posted());
    match nodes {
        Nodes::Curve(c) => {
            table(&mut out, &["x".into(), "y".into()], c.weight.as_deref(), c.y.len(), |i, row| {
                row.extend_from_slice(&[c.x[i], c.y[i]]);
            });
        }
        Nodes::Scattered(s) => {
            let names = ["u".into(), "v".into(), "z".into()];
            table(&mut out, &names, s.weight.as_deref(), s.z.len(), |i, row| {
                row.extend_from_slice(&[s.u[i], s.v[i], s.z[i]]);
            });
        }
        Nodes::Grid(g) => {
            let names = ["u".into(), "v".into(), "z".into()];
            table(&mut out, &names, g.weight.as_deref(), g.z.len(), |i, row| {
                row.extend_from_slice(&[g.u[i / g.v.len()], g.v[i % g.v.len()], height(g, i)]);
            });
        }
        Nodes::Matrix(m) => {
            let mut names: Vec<String> = match &m.names {
                Some(names) => names.clone(),
                None => (1..=m.columns).map(|j| format!("x{j}")).collect(),
            };
            names.push("y".into());
            table(&mut out, &names, m.weight.as_deref(), m.y.len(), |i, row| {
                row.extend_from_slice(&m.x[i * m.columns..(i + 1) * m.columns]);
                row.push(m.y[i]);
            });
        }
    }
    out
}

fn height(grid: &Grid, i: usize) -> f64 {
    if grid.valid.as_ref().is_none_or(|valid| valid[i]) { grid.z[i] } else { f64::NAN }
}

fn table(
    out: &mut Vec<u8>,
    names: &[String],
    weight: Option<&[f64]>,
    count: usize,
    fill: impl Fn(usize, &mut Vec<f64>),
) {
    let cell = |name: &String| {
        if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.clone() }
    };
    let mut header: Vec<String> = names.iter().map(cell).collect();
    header.extend(weight.map(|_| "weight".to_owned()));
    out.extend_from_slice(header.join(",").as_bytes());
    out.push(b'\n');
    let mut row = Vec::new();
    for i in (0..count).asking(200) {
        row.clear();
        fill(i, &mut row);
        row.extend(weight.map(|weight| weight[i]));
        for (j, value) in row.iter().enumerate() {
            if j > 0 {
                out.push(b',');
            }
            if value.is_finite() {
                number(out, *value);
            }
        }
        out.push(b'\n');
    }
}

fn field(out: &mut Vec<u8>, name: &str, values: &[f64]) {
    // Writing into a vector cannot fail.
    let _written = write!(out, ",\"{name}\":");
    array(out, values);
}

fn weight(out: &mut Vec<u8>, weight: Option<&[f64]>, columns: Option<usize>) {
    let Some(weight) = weight else { return };
    match columns {
        None => field(out, "weight", weight),
        Some(columns) => {
            out.extend_from_slice(br#","weight":"#);
            rows(out, weight, columns, number);
        }
    }
}

fn array(out: &mut Vec<u8>, values: &[f64]) {
    list(out, values.iter().copied(), number);
}

fn rows<T: Copy>(out: &mut Vec<u8>, values: &[T], columns: usize, write: impl Fn(&mut Vec<u8>, T)) {
    list(out, values.chunks(columns.max(1)), |out, row| list(out, row.iter().copied(), &write));
}

fn list<T>(out: &mut Vec<u8>, values: impl Iterator<Item = T>, write: impl Fn(&mut Vec<u8>, T)) {
    out.push(b'[');
    for (i, value) in values.enumerate().asking(30) {
        if i > 0 {
            out.push(b',');
        }
        write(out, value);
    }
    out.push(b']');
}

/// The shortest text that reads back to the same double; `null` for what is not finite.
fn number(out: &mut Vec<u8>, value: f64) {
    let _written = serde_json::to_writer(out, &value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::{nodes_codec, reader};

    fn examples() -> Vec<Nodes> {
        vec![
            Nodes::curve(vec![1.0, 0.1], vec![3.0, 1e-308], Some(vec![0.0, 2.0])).unwrap(),
            Nodes::scattered(vec![1.0], vec![-2.5e300], vec![3.0], None).unwrap(),
            Nodes::grid(vec![0.0, 1.0], vec![5.0], vec![f64::NAN, 1.0], Some(vec![true, false]), None).unwrap(),
            Nodes::grid(vec![0.0, 1.0], vec![5.0], vec![2.0, 1.0], None, Some(vec![1.0, 0.5])).unwrap(),
            Nodes::matrix(vec![1.0, 2.0, 3.0, 4.0], 2, vec![5.0, 6.0], Some(vec!["a".into(), "\"µ".into()]), None)
                .unwrap(),
        ]
    }

    #[test]
    fn json_reads_back_to_the_same_nodes() {
        for nodes in examples() {
            let text = String::from_utf8(to_json(&nodes)).unwrap();
            let request = format!(r#"{{"nodes":{text},"model":{{"type":"linear"}}}}"#);
            let (back, _, _) = reader::read_fit::<reader::NoExtra>(request.as_bytes()).unwrap();
            assert_eq!(nodes_codec::encode(&back), nodes_codec::encode(&nodes), "{text}");
        }
    }

    #[test]
    fn tables_have_a_header_and_empty_cells_for_missing_nodes() {
        let table: Vec<String> = examples().iter().map(|nodes| String::from_utf8(to_csv(nodes)).unwrap()).collect();
        assert_eq!(table[0], "x,y,weight\n1.0,3.0,0.0\n0.1,1e-308,2.0\n");
        assert_eq!(table[1], "u,v,z\n1.0,-2.5e+300,3.0\n");
        assert_eq!(table[2], "u,v,z\n0.0,5.0,\n1.0,5.0,\n");
        assert_eq!(table[3], "u,v,z,weight\n0.0,5.0,2.0,1.0\n1.0,5.0,1.0,0.5\n");
        assert_eq!(table[4], "a,\"\"\"µ\",y\n1.0,2.0,5.0\n3.0,4.0,6.0\n");
    }
}
