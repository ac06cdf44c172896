//! The rows of a job: which there are, and their columns, in the order of the text. Rows are named
//! as the job's own numbers do it, by iteration and position, never by a key of the store.

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Integer,
    /// A figure, by its bits.
    Real,
    Text,
    Bytes,
    Id,
    Time,
    /// A text that a store may keep in another form.
    Document,
}

#[derive(Clone, Copy, Debug)]
pub struct Column {
    pub name: &'static str,
    pub kind: Kind,
}

/// A kind of row.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    pub name: &'static str,
    pub columns: &'static [Column],
}

macro_rules! tables {
    ($($table:ident: { $($column:ident: $kind:ident),+ $(,)? })+) => {
        &[$(Table {
            name: stringify!($table),
            columns: &[$(Column { name: stringify!($column), kind: Kind::$kind }),+],
        }),+]
    };
}

/// In this order rows can be stored: each names such as stand before it.
pub const TABLES: &[Table] = tables! {
    job: {
        name: Text, part_number: Text, serial_number: Text, machine: Text, gear: Text, tags: Text,
        version: Integer, created_at: Time, updated_at: Time, requirements: Text,
    }
    iteration: {
        number: Integer, id: Id, measured_at: Time, instrument: Text, operator: Text, note: Text,
        flank: Text, tooth: Text, axes: Text, created_at: Time,
    }
    nodes: { number: Integer, count: Integer, data: Bytes }
    fit: {
        number: Integer, position: Integer, id: Id, reason: Text, created_at: Time,
        lambda_star: Real, criterion: Text, scheme: Text, count: Integer, condition: Real,
        regularized_condition: Real, bias_norm: Real, bias_sharp_bound: Real, rms: Real, max_abs: Real,
        actor: Text, flank_figures: Text, spec: Document, result: Document,
    }
    choice: { number: Integer, position: Integer, fit: Integer, reason: Text, created_at: Time, actor: Text }
    decision: {
        number: Integer, position: Integer, decision: Text, reason: Text, created_at: Time, actor: Text,
        concession: Integer,
    }
    record: {
        number: Integer, position: Integer, id: Id, kind: Text, method: Text, created_at: Time,
        request: Document, result: Document, gear: Text, actor: Text, class: Integer,
        measurand: Text,
    }
    stream: {
        id: Id, spec: Document, forgetting_factor: Real, sequence: Integer, node_count: Integer,
        input_sha256: Bytes, flank: Text, tooth: Text, axes: Text, iteration: Integer, version: Integer,
        created_at: Time, updated_at: Time,
    }
    block: { stream: Id, sequence: Integer, sha256: Bytes, count: Integer, data: Bytes, created_at: Time }
    state: { stream: Id, sequence: Integer, data: Bytes }
    event: {
        number: Integer, kind: Text, iteration: Integer, fit: Integer, position: Integer, stream: Id,
        state: Text, sequence: Integer, node_count: Integer, operation: Id, operation_state: Text,
        created_at: Time, record: Id,
    }
    audit: {
        number: Integer, id: Id, at: Time, actor: Text, action: Text, target: Text, request_id: Text,
        peer: Text, contents: Bytes, outcome: Text, previous: Bytes, sha256: Bytes,
    }
    purge: { at: Time, reason: Text, archive_sha256: Bytes }
};
