-- Iterations, their nodes, their fits, and the two kinds of events. Rows of these tables are only ever added.
CREATE TABLE iterations (
    seq         INTEGER PRIMARY KEY,
    id          BLOB    NOT NULL CHECK (length(id) = 16),
    job         INTEGER NOT NULL REFERENCES jobs (seq),
    number      INTEGER NOT NULL CHECK (number >= 1),
    measured_at TEXT    CHECK (length(measured_at) = 27),
    instrument  TEXT,
    operator    TEXT,
    note        TEXT,
    created_at  TEXT    NOT NULL CHECK (length(created_at) = 27),
    UNIQUE (job, number)
) STRICT;

-- The nodes as posted, in a compact binary form whose first byte tells its version.
CREATE TABLE nodes (
    iteration INTEGER PRIMARY KEY REFERENCES iterations (seq),
    count     INTEGER NOT NULL CHECK (count >= 0),
    data      BLOB    NOT NULL
) STRICT;

-- spec: the fit request without its nodes; result: the answer, byte for byte. The figures are those of the trace; one that
-- does not exist is NULL.
CREATE TABLE fits (
    seq                   INTEGER PRIMARY KEY,
    id                    BLOB    NOT NULL CHECK (length(id) = 16),
    iteration             INTEGER NOT NULL REFERENCES iterations (seq),
    reason                TEXT,
    created_at            TEXT    NOT NULL CHECK (length(created_at) = 27),
    lambda_star           REAL,
    criterion             TEXT,
    scheme                TEXT,
    count                 INTEGER,
    condition             REAL,
    regularized_condition REAL,
    bias_norm             REAL,
    bias_sharp_bound      REAL,
    rms                   REAL,
    max_abs               REAL,
    spec                  TEXT    NOT NULL,
    result                TEXT    NOT NULL,
    UNIQUE (iteration, seq)
) STRICT;

-- Which fit stands: the choice with the greatest position. The pair refers to fits, so a fit of another iteration is refused.
CREATE TABLE fit_choices (
    iteration  INTEGER NOT NULL,
    position   INTEGER NOT NULL CHECK (position >= 1),
    fit        INTEGER NOT NULL,
    reason     TEXT,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (iteration, position),
    FOREIGN KEY (iteration, fit) REFERENCES fits (iteration, seq)
) STRICT, WITHOUT ROWID;

-- What was decided: the decision with the greatest position holds.
CREATE TABLE decisions (
    iteration  INTEGER NOT NULL REFERENCES iterations (seq),
    position   INTEGER NOT NULL CHECK (position >= 1),
    decision   TEXT    NOT NULL CHECK (decision IN ('accept', 'remachine', 'reject')),
    reason     TEXT,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (iteration, position)
) STRICT, WITHOUT ROWID;
