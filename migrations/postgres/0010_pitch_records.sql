-- Pitches are a kind of record.
ALTER TABLE records DROP CONSTRAINT records_kind_check;
ALTER TABLE records ADD CONSTRAINT records_kind_check
    CHECK (kind IN ('curve', 'surface', 'deviations', 'evaluation', 'pitch', 'correction')) NOT VALID;
ALTER TABLE records VALIDATE CONSTRAINT records_kind_check;
