-- Pitches are a kind of record. SQLite cannot change a CHECK; only its text is changed here, as https://sqlite.org/lang_altertable.html
-- (section 7) describes it, so that the columns, indices and triggers that the table has by now stay as they are. No row is touched.
PRAGMA writable_schema = ON;

UPDATE sqlite_schema
SET sql = replace(sql, '''evaluation'', ''correction''', '''evaluation'', ''pitch'', ''correction''')
WHERE type = 'table' AND name = 'records';

-- This connection reads the schema again; any other one does so because a table came and went.
PRAGMA writable_schema = RESET;
CREATE TABLE schema_was_changed (seq INTEGER PRIMARY KEY) STRICT;
DROP TABLE schema_was_changed;
