// Drives our forum server from the official TypeScript SDK: lists, reads, writes, is told of a new post. Prints JSON.
import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";
import { StreamableHTTPClientTransport } from "@modelcontextprotocol/sdk/client/streamableHttp.js";
import { ResourceUpdatedNotificationSchema } from "@modelcontextprotocol/sdk/types.js";

const { url, token, command, args } = JSON.parse(process.argv[2]);
const transport = url
  ? new StreamableHTTPClientTransport(new URL(url), { requestInit: { headers: { Authorization: `Bearer ${token}` } } })
  : new StdioClientTransport({ command, args, env: process.env, stderr: "ignore" });
const client = new Client({ name: "drive", version: "1" });
await client.connect(transport);

const call = async (name, given = {}) => (await client.callTool({ name, arguments: given })).structuredContent;
const tools = (await client.listTools()).tools.map((t) => t.name);
const boards = await call("list_boards");
const wrote = await call("create_topic", { board_id: "talk", title: "From TypeScript", body: "hello", status: "asking" });
const topic_id = wrote.data.post.topic_id;
const uri = `forum://topic/${topic_id}`;
const updated = new Promise((resolve) =>
  client.setNotificationHandler(ResourceUpdatedNotificationSchema, (told) => resolve(told.params.uri)));
await client.subscribeResource({ uri });
const writing = setInterval(() => call("reply_to_topic", { topic_id, body: "news" }), 200);
const told = await updated;
clearInterval(writing);
const topic = await call("get_topic", { topic_id, limit: 1 });
const resource = JSON.parse((await client.readResource({ uri })).contents[0].text);
const prompts = (await client.listPrompts()).prompts.map((p) => p.name);
const refused = await client.callTool({ name: "get_topic", arguments: { topic_id: "9999" } });
console.log(JSON.stringify({ tools, boards, wrote, told, topic, resource, prompts, refused, server: client.getServerVersion() }));
await client.close();
