//! No circles of files: what a file imports leads nowhere back to it. What a `mod.rs` hands on
//! (`pub use`) is no import.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

use super::{root, rust_files, split, tokens};

/// Where the matter itself is a recursion: a patchwork is made of surfaces and is one, a request is
/// read again past what was refused, and the router serves the document that is made of its routes.
const RECURSIONS: [&[&str]; 3] = [
    &["api::json::mended", "api::json::reader"],
    &["geometry::surface::patchwork", "geometry::surface::shape"],
    &["http::meta", "http::openapi", "http::router"],
];

/// Names from the crate's root down.
type Module = Vec<String>;

/// A path that a file names, and whether it is handed on.
struct Named {
    path: Module,
    handed_on: bool,
}

/// The paths of one `use`, from `at` on; answers where it ends.
fn expand(tokens: &[String], mut at: usize, mut path: Module, out: &mut Vec<Module>) -> usize {
    let is = |at: usize, what: &str| tokens.get(at).is_some_and(|token| token == what);
    loop {
        if is(at, "{") {
            at += 1;
            while at < tokens.len() && !is(at, "}") {
                at = expand(tokens, at, path.clone(), out);
                at += usize::from(is(at, ","));
            }
            return at + 1;
        }
        let Some(name) = tokens.get(at) else { return at };
        path.push(name.clone());
        if is(at + 1, ":") && is(at + 2, ":") {
            at += 3;
            continue;
        }
        out.push(path);
        return if is(at + 1, "as") { at + 3 } else { at + 1 };
    }
}

/// Every path that begins at the crate or near the file.
fn named(tokens: &[String]) -> Vec<Named> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        let before = if at > 0 { tokens[at - 1].as_str() } else { "" };
        let goes_on = at > 1 && before == ":" && tokens[at - 2] == ":";
        let mut paths = Vec::new();
        let next = match tokens[at].as_str() {
            "use" => expand(tokens, at + 1, Vec::new(), &mut paths),
            "crate" | "super" | "self" if !goes_on && !matches!(before, "$" | "in") => {
                let mut end = at;
                let mut path = vec![tokens[at].clone()];
                while tokens.get(end + 1).is_some_and(|t| t == ":") && tokens.get(end + 2).is_some_and(|t| t == ":") {
                    let Some(name) = tokens.get(end + 3).filter(|name| *name != "{" && *name != "<") else { break };
                    path.push(name.clone());
                    end += 3;
                }
                paths.extend((path.len() > 1).then_some(path));
                end + 1
            }
            _ => at + 1,
        };
        let handed_on = tokens[at] == "use" && matches!(before, "pub" | ")");
        found.extend(paths.into_iter().map(|path| Named { path, handed_on }));
        at = next.max(at + 1);
    }
    found
}

/// The source without its unit tests.
fn without_tests(mut tokens: Vec<String>) -> Vec<String> {
    let head = ["#", "[", "cfg", "(", "test", ")", "]", "mod"];
    let begins = |window: &[String]| window.iter().zip(head).all(|(token, wanted)| token == wanted);
    if let Some(at) = tokens.windows(head.len()).position(begins) {
        tokens.truncate(at);
    }
    tokens
}

/// The files of a crate and which of them each imports.
fn imports(source: &str) -> BTreeMap<Module, BTreeSet<Module>> {
    let base = root().join(source);
    let mut names: BTreeMap<Module, Vec<Named>> = BTreeMap::new();
    for file in rust_files(&base) {
        let inside = file.strip_prefix(&base).expect("below the sources").with_extension("");
        let mut module: Module = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        module.pop_if(|last| last == "mod" || last == "lib");
        if module.last().is_none_or(|last| !last.ends_with("tests")) {
            let code = split(&fs::read_to_string(&file).expect("a source file")).0;
            names.insert(module, named(&without_tests(tokens(&code))));
        }
    }
    let absolute = |module: &Module, path: &Module| -> Option<Module> {
        let (mut from, mut rest) = (module.clone(), path.as_slice());
        match rest[0].as_str() {
            "crate" => from.clear(),
            "self" | "super" => {}
            name => {
                from.push(name.to_owned());
                if !names.contains_key(&from) {
                    return None;
                }
            }
        }
        if rest[0] != "super" {
            rest = &rest[1..];
        }
        while rest.first().is_some_and(|name| name == "super") {
            from.pop();
            rest = &rest[1..];
        }
        from.extend(rest.iter().filter(|name| *name != "self").cloned());
        Some(from)
    };
    let mut handed_on: BTreeMap<Module, Module> = BTreeMap::new();
    for (module, found) in &names {
        for Named { path, .. } in found.iter().filter(|named| named.handed_on) {
            if let (Some(target), Some(last)) = (absolute(module, path), path.last()) {
                handed_on.insert([module.as_slice(), std::slice::from_ref(last)].concat(), target);
            }
        }
    }
    let resolve = |mut path: Module| -> Option<Module> {
        for _ in 0..8 {
            if names.contains_key(&path) {
                return Some(path);
            }
            let known = (0..path.len()).rev().find(|&k| names.contains_key(&path[..k]))?;
            match handed_on.get(&path[..=known]).filter(|target| **target != path[..=known]) {
                Some(target) => path = [target.as_slice(), &path[known + 1..]].concat(),
                None => return Some(path[..known].to_vec()),
            }
        }
        None
    };
    names
        .iter()
        .map(|(module, found)| {
            let used = found.iter().filter(|named| !named.handed_on);
            let targets =
                used.filter_map(|named| resolve(absolute(module, &named.path)?)).filter(|target| target != module);
            (module.clone(), targets.collect())
        })
        .collect()
}

/// Everything that a file leads to.
fn reached(graph: &BTreeMap<Module, BTreeSet<Module>>, from: &Module) -> BTreeSet<Module> {
    let mut seen = BTreeSet::new();
    let mut open = vec![from.clone()];
    while let Some(module) = open.pop() {
        for target in &graph[&module] {
            if seen.insert(target.clone()) {
                open.push(target.clone());
            }
        }
    }
    seen
}

#[test]
fn files_import_each_other_in_no_circle() {
    let mut circles = BTreeSet::new();
    let mut arrows = 0;
    for source in ["engine/src", "src"] {
        let graph = imports(source);
        arrows += graph.values().map(BTreeSet::len).sum::<usize>();
        let reach: BTreeMap<&Module, BTreeSet<Module>> = graph.keys().map(|m| (m, reached(&graph, m))).collect();
        for module in graph.keys().filter(|module| reach[module].contains(*module)) {
            let circle = reach[module].iter().filter(|other| reach[other].contains(module));
            circles.insert(circle.map(|part| part.join("::")).collect::<Vec<String>>());
        }
    }
    assert!(arrows > 1500, "only {arrows} imports were found");
    let recursions = RECURSIONS.iter().map(|circle| circle.iter().map(|part| (*part).to_owned()).collect());
    assert_eq!(circles, recursions.collect(), "left: circles of files, right: the recursions that are known");
}
