-- Motions packed, one row a capture, instead of a row a frame: half the size. After this text,
-- motiondb packs the rows of motion_frame into it and drops that table (connection/migrations.py).
CREATE TABLE motion (
    capture_id BIGINT NOT NULL,
    n_frames BIGINT NOT NULL,
    poses BLOB USING COMPRESSION uncompressed NOT NULL
);
