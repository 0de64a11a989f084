-- Motions and original files may lie in Parquet files beside the database.
CREATE TABLE parquet_file (
    file_id BIGINT PRIMARY KEY,
    place VARCHAR NOT NULL,
    name VARCHAR NOT NULL UNIQUE,
    n_bytes BIGINT NOT NULL,
    sha256 VARCHAR NOT NULL
);
ALTER TABLE source
    ADD COLUMN data_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
ALTER TABLE source
    ADD COLUMN skeleton_data_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
ALTER TABLE motion
    ADD COLUMN poses_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
ALTER TABLE IF EXISTS trash.source
    ADD COLUMN data_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
ALTER TABLE IF EXISTS trash.source
    ADD COLUMN skeleton_data_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
ALTER TABLE IF EXISTS trash.motion
    ADD COLUMN poses_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
