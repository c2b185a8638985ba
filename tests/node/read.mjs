// Reads a log with @mcap/core, by its index and as a stream, and compares a topic with the table that
// `gtfdi log export --time seconds` made of it.
//
//     node read.mjs LOG.mcap TABLE.csv TOPIC
//
// Prints what was found as JSON; exit code 1, and the reason, where anything differs.

import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { open } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const [path, table, topic] = process.argv.slice(2);
if (!topic) {
  fail("expected LOG.mcap TABLE.csv TOPIC");
}

function fail(reason) {
  console.error(`${path ?? "read.mjs"}: ${reason}`);
  process.exit(1);
}

function expect(what, expected, found) {
  if (!Object.is(expected, found)) {
    fail(`${what}: expected ${expected}, found ${found}`);
  }
}

const decompressHandlers = {
  zstd: (buffer, size) => decompress(buffer, new Uint8Array(Number(size))),
};

// Reads some of a file when it is asked to.
class FileReadable {
  constructor(handle) {
    this.handle = handle;
  }
  async size() {
    return BigInt((await this.handle.stat()).size);
  }
  async read(offset, length) {
    const buffer = new Uint8Array(Number(length));
    await this.handle.read(buffer, 0, Number(length), Number(offset));
    return buffer;
  }
}

// The fields of a message by their tags, in order, as functions of its bytes.
function decoder(schema, channel) {
  const set = descriptor.FileDescriptorSet.decode(schema.data);
  const type = protobuf.Root.fromDescriptor(set).lookupType(schema.name);
  const tags = JSON.parse(channel.metadata.get("tags"));
  const fields = type.fieldsArray.map((field) => field.name);
  return {
    tags: type.fieldsArray.map((field) => tags[field.name] ?? tags[snake(field.name, tags)]),
    decode: (data) => {
      const message = type.decode(data);
      return fields.map((name) => (Object.hasOwn(message, name) ? message[name] : null));
    },
  };
}

// protobufjs writes `a_v` as `aV`.
function snake(name, tags) {
  return Object.keys(tags).find((tag) => protobuf.util.camelCase(tag) === name);
}

async function byIndex() {
  const handle = await open(path);
  const reader = await McapIndexedReader.Initialize({
    readable: new FileReadable(handle),
    decompressHandlers,
  });
  const channels = [...reader.channelsById.values()];
  const channel = channels.find((own) => own.topic === topic) ?? fail(`no topic ${topic}`);
  const { tags, decode } = decoder(reader.schemasById.get(channel.schemaId), channel);
  const rows = [];
  for await (const message of reader.readMessages({ topics: [topic] })) {
    rows.push([message.logTime, decode(message.data)]);
  }
  const attachments = [];
  for await (const own of reader.readAttachments()) {
    attachments.push([own.name, createHash("sha256").update(own.data).digest("hex")]);
  }
  const metadata = [];
  for await (const own of reader.readMetadata()) {
    metadata.push(own.name);
  }
  await handle.close();
  const topics = channels.map((own) => own.topic).sort();
  return { tags, rows, attachments, metadata, topics };
}

function byStream() {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  const bytes = readFileSync(path);
  const schemas = new Map();
  const decoders = new Map();
  const rows = [];
  for (let start = 0; start < bytes.length; start += 1 << 16) {
    reader.append(bytes.subarray(start, start + (1 << 16)));
    for (let record; (record = reader.nextRecord()); ) {
      if (record.type === "Schema") {
        schemas.set(record.id, record);
      } else if (record.type === "Channel" && record.topic === topic) {
        decoders.set(record.id, decoder(schemas.get(record.schemaId), record));
      } else if (record.type === "Message" && decoders.has(record.channelId)) {
        rows.push([record.logTime, decoders.get(record.channelId).decode(record.data)]);
      }
    }
  }
  expect("the end of the file is reached", true, reader.done());
  return rows;
}

const { tags, rows, ...about } = await byIndex();
const streamed = byStream();
const lines = readFileSync(table, "utf8").trimEnd().split("\n");
expect("the header", ["time", ...tags].join(","), lines[0]);
expect("rows of the table", rows.length, lines.length - 1);
expect("messages of the stream", rows.length, streamed.length);
let numbers = 0;
rows.forEach(([time, values], k) => {
  expect(`time of message ${k} of the stream`, time, streamed[k][0]);
  const cells = lines[k + 1].split(",");
  const seconds = `${(time - rows[0][0]) / 1000000000n}.${String((time - rows[0][0]) % 1000000000n).padStart(9, "0")}`;
  expect(`time of row ${k}`, seconds, cells[0]);
  values.forEach((value, place) => {
    const cell = cells[place + 1] === "" ? null : Number(cells[place + 1]);
    expect(`row ${k}, ${tags[place]}`, cell, value);
    expect(`row ${k} of the stream, ${tags[place]}`, value, streamed[k][1][place]);
    numbers += 1;
  });
});
console.log(JSON.stringify({ topic, messages: rows.length, numbers, ...about }));
