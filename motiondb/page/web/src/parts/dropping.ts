/** Files that are dropped or chosen: single files, or folders with their contents. */

export interface NamedFile {
  /** The path inside the dropped folder, or the file's name. */
  path: string;
  file: File;
}

/**
 * Call a function with the files that are dropped onto an element, which has the class `dropping` during the drag.
 * What is returned ends this.
 */
export function onDrop(element: HTMLElement, drop: (files: NamedFile[]) => void): () => void {
  const ending = new AbortController();
  const { signal } = ending;
  let depth = 0;
  const hasFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  const mark = (): void => void element.classList.toggle("dropping", depth > 0);
  const enter = (event: DragEvent): void => {
    if (!hasFiles(event)) return;
    depth += 1;
    mark();
  };
  const leave = (event: DragEvent): void => {
    if (!hasFiles(event)) return;
    depth = Math.max(depth - 1, 0);
    mark();
  };
  const take = (event: DragEvent): void => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    depth = 0;
    mark();
    void droppedFiles(event.dataTransfer!).then(drop);
  };
  element.addEventListener("dragenter", enter, { signal });
  element.addEventListener("dragleave", leave, { signal });
  element.addEventListener("dragover", (event) => hasFiles(event) && event.preventDefault(), { signal });
  element.addEventListener("drop", take, { signal });
  return () => ending.abort();
}

/** The files of a drop; folders are walked through. */
async function droppedFiles(transfer: DataTransfer): Promise<NamedFile[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.() ?? null);
  if (entries.some((entry) => entry?.isDirectory)) {
    const found: NamedFile[] = [];
    for (const entry of entries) if (entry) await walk(entry, found);
    return found;
  }
  return fromList(transfer.files);
}

async function walk(entry: FileSystemEntry, into: NamedFile[]): Promise<void> {
  const path = entry.fullPath.replace(/^\//, "");
  if (entry.isFile) {
    const file = await new Promise<File>((done, fail) => (entry as FileSystemFileEntry).file(done, fail));
    into.push({ path, file });
    return;
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((done, fail) => reader.readEntries(done, fail));
    if (some.length === 0) return;
    for (const one of some) await walk(one, into);
  }
}

/** The files of an input element. */
export function fromList(files: FileList | null): NamedFile[] {
  return [...(files ?? [])].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
}
