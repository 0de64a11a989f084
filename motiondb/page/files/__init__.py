"""What lies on the disk: uploads, folders to add from, boards, the files of the page."""
