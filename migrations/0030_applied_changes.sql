-- The changes of settings that were made are a kind of record, and so is the correction of a whole gear. As 0020, only the text of the
-- CHECK is changed; no row is touched.
PRAGMA writable_schema = ON;

UPDATE sqlite_schema
SET sql = replace(sql, '''pitch'', ''correction''', '''pitch'', ''correction'', ''gear_correction'', ''applied''')
WHERE type = 'table' AND name = 'records';

-- This connection reads the schema again; any other one does so because a table came and went.
PRAGMA writable_schema = RESET;
CREATE TABLE schema_was_changed (seq INTEGER PRIMARY KEY) STRICT;
DROP TABLE schema_was_changed;
