-- Files that were added again under another name: which capture has their content.
CREATE TABLE same_file (
    path VARCHAR PRIMARY KEY,
    capture_id BIGINT NOT NULL
);
