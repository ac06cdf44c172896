-- The mappings by which tables became iterations, proposed for the next table of the same instrument and form. key: digest of both, so
-- that no name is stored. mapping: as it was sent, without the names of columns. The number of a tenant's is bounded; a new one replaces
-- the oldest.
CREATE TABLE table_mappings (
    tenant text NOT NULL,
    key bytea NOT NULL CHECK (length(key) = 32),
    mapping text NOT NULL,
    kept_at timestamptz NOT NULL,
    PRIMARY KEY (tenant, key)
);
