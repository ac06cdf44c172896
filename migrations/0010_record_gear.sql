-- The gear that the job had when a record was made, a JSON document as in jobs: the job's may be changed later. Older rows tell none.
ALTER TABLE records ADD COLUMN gear TEXT;
