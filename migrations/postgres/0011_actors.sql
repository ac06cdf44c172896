-- Who did it: the actor of the caller, where one is known. Rows from before have none.
ALTER TABLE fits ADD COLUMN actor text;
ALTER TABLE fit_choices ADD COLUMN actor text;
ALTER TABLE decisions ADD COLUMN actor text;
ALTER TABLE records ADD COLUMN actor text;
