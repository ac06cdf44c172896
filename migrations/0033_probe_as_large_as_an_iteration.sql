-- What is written to find out whether the disk takes it is as large as an iteration: a single page may fit where nothing else does.
ALTER TABLE probe ADD COLUMN filler BLOB;
