-- Streams: nodes that arrive while the probe is still moving. sequence and node_count are those of the last block, version moves
-- on with every change, iteration is set when the stream has become one. input_sha256 is a chain over spec and blocks.
CREATE TABLE streams (
    seq               INTEGER PRIMARY KEY,
    id                BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    job               INTEGER NOT NULL REFERENCES jobs (seq),
    spec              TEXT    NOT NULL,
    forgetting_factor REAL    NOT NULL CHECK (forgetting_factor > 0 AND forgetting_factor <= 1),
    sequence          INTEGER NOT NULL CHECK (sequence >= 0),
    node_count        INTEGER NOT NULL CHECK (node_count >= 0),
    input_sha256      BLOB    NOT NULL CHECK (length(input_sha256) = 32),
    iteration         INTEGER REFERENCES iterations (seq),
    version           INTEGER NOT NULL CHECK (version >= 1),
    created_at        TEXT    NOT NULL CHECK (length(created_at) = 27),
    updated_at        TEXT    NOT NULL CHECK (length(updated_at) = 27)
) STRICT;

CREATE INDEX streams_of_job ON streams (job);

-- Blocks of nodes as posted (the form of table nodes), until the stream is finished; then its iteration holds them.
CREATE TABLE stream_blocks (
    seq        INTEGER PRIMARY KEY,
    stream     INTEGER NOT NULL REFERENCES streams (seq),
    sequence   INTEGER NOT NULL CHECK (sequence >= 1),
    sha256     BLOB    NOT NULL CHECK (length(sha256) = 32),
    count      INTEGER NOT NULL CHECK (count >= 1),
    data       BLOB    NOT NULL,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    UNIQUE (stream, sequence)
) STRICT;

-- The estimate's numbers after a block, so that an open stream goes on without reading every node again.
CREATE TABLE stream_states (
    stream   INTEGER PRIMARY KEY REFERENCES streams (seq),
    sequence INTEGER NOT NULL CHECK (sequence >= 1),
    data     BLOB    NOT NULL
) STRICT;
