-- The mappings by which tables became iterations, proposed for the next table of the same instrument and form. key: digest of both, so
-- that no name is stored. mapping: as it was sent, without the names of columns. The number of a tenant's is bounded; a new one replaces
-- the oldest.
CREATE TABLE table_mappings (
    tenant  TEXT NOT NULL,
    key     BLOB NOT NULL CHECK (length(key) = 32),
    mapping TEXT NOT NULL CHECK (json_valid(mapping)),
    kept_at TEXT NOT NULL CHECK (length(kept_at) = 27),
    PRIMARY KEY (tenant, key)
) STRICT, WITHOUT ROWID;
