-- The changes of settings that were made are a kind of record, and so is the correction of a whole gear.
ALTER TABLE records DROP CONSTRAINT records_kind_check;
ALTER TABLE records ADD CONSTRAINT records_kind_check
    CHECK (kind IN ('curve', 'surface', 'deviations', 'evaluation', 'pitch', 'correction', 'gear_correction', 'applied')) NOT VALID;
ALTER TABLE records VALIDATE CONSTRAINT records_kind_check;
