-- Events of a job tell that it was purged. Rows and triggers stay as they are, so the text alone is changed, as 0019 does; where it is another
-- text by now, it stays.
PRAGMA writable_schema = ON;
UPDATE sqlite_schema SET sql = replace(sql, 'OR kind = ''operation'')', 'OR kind = ''operation'' OR kind = ''purged'')')
WHERE type = 'table' AND name = 'events';
PRAGMA writable_schema = RESET;

CREATE TRIGGER events_of_purges AFTER INSERT ON purges
BEGIN
    INSERT INTO events (job, number, kind, created_at)
    VALUES (NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'purged', NEW.at);
END;
