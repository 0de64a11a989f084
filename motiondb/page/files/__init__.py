"""Files on the disk: uploads, folders to add captures from, boards, the built page."""
