-- What the nodes of an iteration (and of a stream) are of: the flank, the tooth, and what their axes mean (a JSON document checked
-- at the door). Older rows tell none of it.
ALTER TABLE iterations ADD COLUMN flank TEXT CHECK (flank IN ('left', 'right'));
ALTER TABLE iterations ADD COLUMN tooth TEXT;
ALTER TABLE iterations ADD COLUMN axes TEXT;

ALTER TABLE streams ADD COLUMN flank TEXT CHECK (flank IN ('left', 'right'));
ALTER TABLE streams ADD COLUMN tooth TEXT;
ALTER TABLE streams ADD COLUMN axes TEXT;

-- One row that is written to find out whether the database can be written to.
CREATE TABLE probe (
    id         INTEGER PRIMARY KEY CHECK (id = 1),
    checked_at TEXT    NOT NULL CHECK (length(checked_at) = 27)
) STRICT;
