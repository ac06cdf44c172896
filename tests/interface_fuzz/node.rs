//! JSON as a tree that can also hold invalid JSON: numbers keep their text, names may occur twice.

#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    Object(Vec<(String, Node)>),
    Array(Vec<Node>),
    Text(String),
    /// A number, a word, or any other text.
    Token(String),
}

impl Node {
    pub fn token(text: impl Into<String>) -> Self {
        Node::Token(text.into())
    }

    pub fn text(text: impl Into<String>) -> Self {
        Node::Text(text.into())
    }

    pub fn parse(text: &str) -> Option<Self> {
        serde_json::from_str::<serde_json::Value>(text).ok().map(|value| Node::of(&value))
    }

    pub fn of(value: &serde_json::Value) -> Self {
        use serde_json::Value;
        match value {
            Value::Object(fields) => Node::Object(fields.iter().map(|(k, v)| (k.clone(), Node::of(v))).collect()),
            Value::Array(items) => Node::Array(items.iter().map(Node::of).collect()),
            Value::String(text) => Node::Text(text.clone()),
            other => Node::Token(other.to_string()),
        }
    }

    pub fn written(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Node::Token(text) => out.extend_from_slice(text.as_bytes()),
            Node::Text(text) => write_text(text, out),
            Node::Array(items) => {
                out.push(b'[');
                for (k, item) in items.iter().enumerate() {
                    out.extend((k > 0).then_some(b','));
                    item.write(out);
                }
                out.push(b']');
            }
            Node::Object(fields) => {
                out.push(b'{');
                for (k, (name, item)) in fields.iter().enumerate() {
                    out.extend((k > 0).then_some(b','));
                    write_text(name, out);
                    out.push(b':');
                    item.write(out);
                }
                out.push(b'}');
            }
        }
    }

    pub fn children(&self) -> usize {
        match self {
            Node::Object(fields) => fields.len(),
            Node::Array(items) => items.len(),
            _ => 0,
        }
    }

    pub fn child_mut(&mut self, index: usize) -> Option<&mut Node> {
        match self {
            Node::Object(fields) => fields.get_mut(index).map(|(_, node)| node),
            Node::Array(items) => items.get_mut(index),
            _ => None,
        }
    }

    pub fn field(&self, name: &str) -> Option<&Node> {
        match self {
            Node::Object(fields) => fields.iter().find(|(own, _)| own == name).map(|(_, node)| node),
            _ => None,
        }
    }

    /// Calls with every node and the name of its field.
    pub fn visit<'a>(&'a self, name: &'a str, seen: &mut impl FnMut(&'a str, &'a Node)) {
        seen(name, self);
        match self {
            Node::Object(fields) => fields.iter().for_each(|(name, node)| node.visit(name, seen)),
            Node::Array(items) => items.iter().for_each(|node| node.visit(name, seen)),
            _ => {}
        }
    }

    pub fn visit_mut(&mut self, seen: &mut impl FnMut(&mut Node)) {
        seen(self);
        match self {
            Node::Object(fields) => fields.iter_mut().for_each(|(_, node)| node.visit_mut(seen)),
            Node::Array(items) => items.iter_mut().for_each(|node| node.visit_mut(seen)),
            _ => {}
        }
    }
}

fn write_text(text: &str, out: &mut Vec<u8>) {
    out.extend_from_slice(serde_json::Value::from(text).to_string().as_bytes());
}
