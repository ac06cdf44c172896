//! Nodes as they were posted, as JSON and as CSV, written piece by piece.

use std::sync::Arc;

use flankfit_engine::{
    estimation::data::{Grid, Nodes},
    formats::Pieces,
};

/// Some of the numbers of a node set, in their order.
type Column = fn(&Nodes) -> &[f64];

/// JSON in the contract's form; a missing node is `null`.
pub fn to_json(nodes: Arc<Nodes>) -> Pieces {
    let text = Text { file: Pieces::new(), nodes: Arc::clone(&nodes) };
    let text = match &*nodes {
        Nodes::Curve(_) => text
            .array(r#"{"type":"curve","x":"#, |nodes| if let Nodes::Curve(c) = nodes { c.x() } else { &[] })
            .array(r#","y":"#, |nodes| if let Nodes::Curve(c) = nodes { c.y() } else { &[] }),
        Nodes::Scattered(_) => text
            .array(r#"{"type":"scattered","u":"#, |nodes| if let Nodes::Scattered(s) = nodes { s.u() } else { &[] })
            .array(r#","v":"#, |nodes| if let Nodes::Scattered(s) = nodes { s.v() } else { &[] })
            .array(r#","z":"#, |nodes| if let Nodes::Scattered(s) = nodes { s.z() } else { &[] }),
        Nodes::Grid(g) => {
            let text = text
                .array(r#"{"type":"grid","u":"#, |nodes| if let Nodes::Grid(g) = nodes { g.u() } else { &[] })
                .array(r#","v":"#, |nodes| if let Nodes::Grid(g) = nodes { g.v() } else { &[] })
                .rows(r#","z":"#, g.v().len(), |nodes| if let Nodes::Grid(g) = nodes { g.z() } else { &[] });
            match g.valid() {
                Some(valid) => text.cells(r#","valid":"#, valid.len(), Some(g.v().len()), |nodes, i, out| {
                    let valid = matches!(nodes, Nodes::Grid(grid) if grid.valid().is_some_and(|valid| valid[i]));
                    out.extend_from_slice(if valid { b"true" } else { b"false" });
                }),
                None => text,
            }
        }
        Nodes::Matrix(m) => {
            let text =
                text.rows(r#"{"type":"matrix","x":"#, m.columns(), |nodes| {
                    if let Nodes::Matrix(m) = nodes { m.x() } else { &[] }
                })
                .array(r#","y":"#, |nodes| if let Nodes::Matrix(m) = nodes { m.y() } else { &[] });
            match m.names() {
                Some(names) => {
                    let mut list = br#","names":"#.to_vec();
                    // Strings are always writable as JSON.
                    let _written = serde_json::to_writer(&mut list, names);
                    Text { file: text.file.text(list), ..text }
                }
                None => text,
            }
        }
    };
    let columns = if let Nodes::Grid(g) = &*nodes { Some(g.v().len()) } else { None };
    let text = match (weights(&nodes), columns) {
        ([], _) => text,
        (_, None) => text.array(r#","weight":"#, weights),
        (_, Some(columns)) => text.rows(r#","weight":"#, columns, weights),
    };
    text.file.text("}")
}

/// Empty where there are none.
fn weights(nodes: &Nodes) -> &[f64] {
    let weight = match nodes {
        Nodes::Curve(c) => c.weight(),
        Nodes::Scattered(s) => s.weight(),
        Nodes::Grid(g) => g.weight(),
        Nodes::Matrix(m) => m.weight(),
    };
    weight.unwrap_or_default()
}

/// JSON of nodes, as far as it has been put together.
struct Text {
    file: Pieces,
    nodes: Arc<Nodes>,
}

impl Text {
    fn array(self, before: &str, of: Column) -> Self {
        let count = of(&self.nodes).len();
        self.cells(before, count, None, move |nodes, i, out| number(out, of(nodes)[i]))
    }

    fn rows(self, before: &str, columns: usize, of: Column) -> Self {
        let count = of(&self.nodes).len();
        self.cells(before, count, Some(columns), move |nodes, i, out| number(out, of(nodes)[i]))
    }

    /// A list, or a list of lists of so many `columns`.
    fn cells(
        self,
        before: &str,
        count: usize,
        columns: Option<usize>,
        write: impl Fn(&Nodes, usize, &mut Vec<u8>) + Send + 'static,
    ) -> Self {
        let Text { file, nodes } = self;
        let all = Arc::clone(&nodes);
        let cell = move |i: usize, out: &mut Vec<u8>| {
            let between: &[u8] = match columns {
                Some(_) if i == 0 => b"[",
                Some(columns) if i.is_multiple_of(columns) => b"],[",
                None if i == 0 => b"",
                _ => b",",
            };
            out.extend_from_slice(between);
            write(&all, i, out);
        };
        let end = if columns.is_some() && count > 0 { "]]" } else { "]" };
        Text { file: file.text(format!("{before}[")).lines(count, cell).text(end), nodes }
    }
}

/// CSV with a header: `x,y`, `u,v,z` or the column names and `y`, then `weight` where there are
/// weights. A missing node has an empty height.
pub fn to_csv(nodes: Arc<Nodes>) -> Pieces {
    let mut names: Vec<String> = match &*nodes {
        Nodes::Curve(_) => vec!["x".into(), "y".into()],
        Nodes::Scattered(_) | Nodes::Grid(_) => vec!["u".into(), "v".into(), "z".into()],
        Nodes::Matrix(m) => {
            let plain = || (1..=m.columns()).map(|j| format!("x{j}")).collect();
            let mut names: Vec<String> = m.names().map_or_else(plain, <[String]>::to_vec);
            names.push("y".into());
            names
        }
    };
    names.iter_mut().for_each(cell);
    names.extend((!weights(&nodes).is_empty()).then(|| "weight".to_owned()));
    let mut row = Vec::new();
    let header = format!("{}\n", names.join(","));
    Pieces::new().text(header).lines(nodes.posted(), move |i, out| {
        row.clear();
        match &*nodes {
            Nodes::Curve(c) => row.extend_from_slice(&[c.x()[i], c.y()[i]]),
            Nodes::Scattered(s) => row.extend_from_slice(&[s.u()[i], s.v()[i], s.z()[i]]),
            Nodes::Grid(g) => row.extend_from_slice(&[g.u()[i / g.v().len()], g.v()[i % g.v().len()], height(g, i)]),
            Nodes::Matrix(m) => {
                row.extend_from_slice(&m.x()[i * m.columns()..(i + 1) * m.columns()]);
                row.push(m.y()[i]);
            }
        }
        row.extend(weights(&nodes).get(i));
        for (j, value) in row.iter().enumerate() {
            if j > 0 {
                out.push(b',');
            }
            if value.is_finite() {
                number(out, *value);
            }
        }
        out.push(b'\n');
    })
}

/// Quotes a name that would be taken for several.
fn cell(name: &mut String) {
    if name.contains([',', '"', '\n', '\r']) {
        *name = format!("\"{}\"", name.replace('"', "\"\""));
    }
}

fn height(grid: &Grid, i: usize) -> f64 {
    if grid.valid().as_ref().is_none_or(|valid| valid[i]) { grid.z()[i] } else { f64::NAN }
}

/// The shortest text that reads back to the same double; `null` for what is not finite.
fn number(out: &mut Vec<u8>, value: f64) {
    let _written = serde_json::to_writer(out, &value);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{api::fits::reader, jobs::nodes_codec};

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
            let text = String::from_utf8(to_json(Arc::new(nodes.clone())).whole()).unwrap();
            let request = format!(r#"{{"nodes":{text},"model":{{"type":"linear"}}}}"#);
            let (back, _, _) = reader::read_fit::<()>(request.as_bytes()).unwrap();
            assert_eq!(nodes_codec::encode(&back), nodes_codec::encode(&nodes), "{text}");
        }
    }

    #[test]
    fn tables_have_a_header_and_empty_cells_for_missing_nodes() {
        let table: Vec<String> =
            examples().into_iter().map(|nodes| String::from_utf8(to_csv(Arc::new(nodes)).whole()).unwrap()).collect();
        assert_eq!(table[0], "x,y,weight\n1.0,3.0,0.0\n0.1,1e-308,2.0\n");
        assert_eq!(table[1], "u,v,z\n1.0,-2.5e+300,3.0\n");
        assert_eq!(table[2], "u,v,z\n0.0,5.0,\n1.0,5.0,\n");
        assert_eq!(table[3], "u,v,z,weight\n0.0,5.0,2.0,1.0\n1.0,5.0,1.0,0.5\n");
        assert_eq!(table[4], "a,\"\"\"µ\",y\n1.0,2.0,5.0\n3.0,4.0,6.0\n");
    }
}
