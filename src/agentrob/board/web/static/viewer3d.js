export async function openView() { throw new Error("not built"); }
