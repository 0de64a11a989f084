-- Poses may be packed without w (motiondb/store/catalogue/captures.py), which older versions cannot unpack. The
-- tables stay as they are; poses that were packed before are read as they were.
UPDATE meta SET value = value WHERE key = 'schema';
