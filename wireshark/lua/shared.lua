-- Code that all three dissectors share.

local proto = Proto(KEY, NAME .. ", motion control")
proto.prefs.side = Pref.enum("Sender, if the capture does not tell it", 0,
  "Ports and the direction flags of a pcapng file tell the sender. If both are missing, this does.",
  { { 1, "told by the message", 0 }, { 2, "host", 1 }, { 3, "device", 2 } }, false)

-- What may be wrong with a frame.
local E = {}
local function fault(name, text, group, severity)
  E[name] = ProtoExpert.new(KEY .. ".expert." .. name, text, expert.group[group], expert.severity[severity])
end
fault("short", "The data ends before the fields of the message do", "MALFORMED", "ERROR")
fault("trailing", "Bytes follow the known fields", "PROTOCOL", "NOTE")
fault("unknown", "Unknown message", "UNDECODED", "WARN")
fault("noise", "Bytes that belong to no frame", "PROTOCOL", "WARN")
fault("cut", "The frame is not complete", "REASSEMBLE", "WARN")
fault("checksum", "Wrong checksum", "CHECKSUM", "ERROR")
fault("refused", "The device reports an error", "RESPONSE_CODE", "WARN")
fault("unasked", "The capture has no request for this answer", "SEQUENCE", "NOTE")
fault("again", "Another answer to the same request", "SEQUENCE", "NOTE")

-- Fields, once for all rows that show the same.
local F, all_fields = {}, {}
local SIZE = { u8 = 1, u16 = 2, u32 = 4, i8 = 1, i16 = 2, i32 = 4, f32 = 4, ipv4 = 4, mac = 6 }
local MAKE = {
  u8 = ProtoField.uint8, u16 = ProtoField.uint16, u32 = ProtoField.uint32,
  i8 = ProtoField.int8, i16 = ProtoField.int16, i32 = ProtoField.int32, f32 = ProtoField.float,
  ipv4 = ProtoField.ipv4, mac = ProtoField.ether, bytes = ProtoField.bytes, text = ProtoField.string,
  secret = ProtoField.string,
}

local function keep(field)
  all_fields[#all_fields + 1] = field
  return field
end

-- Name of a field for people.
local function label_of(name)
  return (name:gsub("_", " "):gsub("^%l", string.upper))
end

local function field_of(row)
  local name, kind = row[1], row[2]
  local id = table.concat({ name, kind, tostring(row.names), tostring(row.hex or row.flags ~= nil) }, " ")
  if not F[id] then
    local integer = kind:match("^[ui]%d")
    local style = integer and ((row.hex or row.flags) and base.HEX or base.DEC) or nil
    F[id] = keep(MAKE[kind](KEY .. "." .. name, label_of(name), style, integer and row.names or nil))
  end
  return F[id]
end

-- Prepares rows: finds their fields, and the size of one value or group.
local function rows(list)
  for _, row in ipairs(list) do
    if row.of then
      rows(row.of)
      row.size = 0
      for _, inner in ipairs(row.of) do row.size = row.size + inner.size * (inner.times or 1) end
      if row.count then row.counter = rows({ { row.count, "u8" } })[1] end
    else
      row.size = row.size or SIZE[row[2]]
      row.field = field_of(row)
    end
  end
  return list
end

local function each_rows(messages)
  for _, message in ipairs(messages) do
    rows(message)
    if message.sub then message.sub_row = rows({ { message.sub, "u8" } })[1] end
  end
  return messages
end
each_rows(HOST)
each_rows(DEVICE)

-- Messages with this number; more than one if the data tells them apart.
local found = {}
local function messages_of(side, number)
  local table_of_side = side == "host" and HOST or DEVICE
  local id = side .. number
  if not found[id] then
    found[id] = {}
    for _, message in ipairs(table_of_side) do
      if number == message.also or (number >= message.number and number <= (message.last or message.number)) then
        table.insert(found[id], message)
      end
    end
  end
  return found[id]
end

local function unsigned(range)
  if LITTLE then return range:le_uint() else return range:uint() end
end

-- Number that an integer row shows.
local function number_of(row, range)
  if row[2]:match("^u%d") then return unsigned(range) end
  if not row[2]:match("^i%d") then return nil end
  if LITTLE then return range:le_int() else return range:int() end
end

-- Names of the bits that are set.
local function flags_text(flags, value)
  local names, numbered = {}, type(flags) == "number"
  for index = 1, numbered and flags or #flags do
    local bit = numbered and 2 ^ (index - 1) or flags[index][1]
    if math.floor(value / bit) % 2 == 1 then
      names[#names + 1] = numbered and index or flags[index][2]
      value = value - bit
    end
  end
  if value > 0 then names[#names + 1] = string.format("0x%x", value) end
  if #names == 0 then return "none" end
  return table.concat(names, numbered and "+" or " | ")
end

-- What a person reads beside the number.
local function reading(row, number)
  local unit = row.unit and " " .. row.unit or ""
  if row.flags then return " (" .. flags_text(row.flags, number) .. ")" end
  local word = row.words and (row.words[number] or row.words == N.yes_or_no and "yes")
  if word then return " (" .. word .. ")" end
  if row.ring_tip then
    local bits = number % 65536
    local ring, tip = math.floor(bits / 256), bits % 256
    return string.format(" (ring %s, tip %s)", row.ring_tip[ring] or ring, row.ring_tip[tip] or tip)
  end
  if row.decimals then return string.format(" (%." .. row.decimals .. "f%s)", number / 10 ^ row.decimals, unit) end
  return unit
end

-- Adds one value.
local function add_value(tree, row, range)
  local kind = row[2]
  if kind == "text" or kind == "secret" then
    local text = range:raw()
    -- A text of fixed size ends at its first NUL. Others may have NULs at the end.
    local length = #(row.size and text:match("^[^%z]*") or text:gsub("%z+$", ""))
    if kind == "secret" and not proto.prefs.secrets then
      return tree:add(row.field, string.format("hidden, %d bytes", length))
    end
    if length == 0 then return tree:add(row.field, "") end
    return tree:add_packet_field(row.field, range(0, length), ENC_UTF_8)
  end
  local item
  if LITTLE then item = tree:add_le(row.field, range) else item = tree:add(row.field, range) end
  local number = number_of(row, range)
  if number or row.unit then item:append_text(reading(row, number)) end
  return item
end

-- Adds several values, or several groups of values.
local add_rows
local function add_list(tree, tvb, at, count, row)
  if count == 0 then return at end
  local label = label_of(row[1])
  local list = tree:add(tvb(at, count * row.size), string.format("%s: %d", label, count))
  for index = 1, count do
    local place = tvb(at, row.size)
    if row.of then
      add_rows(list:add(place, string.format("%s %d", label, index)), tvb, at, at + row.size, row.of)
    else
      add_value(list, row, place)
    end
    at = at + row.size
  end
  return at
end

-- Adds the values of a row. Returns the offset after them, or nil if the body ends before.
local function add_row(tree, tvb, at, stop, row)
  local left = stop - at
  if row.rest then
    if left > 0 then add_value(tree, row, tvb(at, left)) end
    return stop
  elseif row.prefixed then
    if left < 2 then return nil end
    local length = unsigned(tvb(at, 2))
    if left < 2 + length then return nil end
    if length > 0 then add_value(tree, row, tvb(at + 2, length)) elseif row[2] ~= "bytes" then tree:add(row.field, "") end
    return at + 2 + length
  elseif row.list then
    return add_list(tree, tvb, at, math.floor(left / row.size), row)
  elseif row.count then
    if left < 1 then return nil end
    local count = tvb(at, 1):uint()
    if left < 1 + count * row.size then return nil end
    add_value(tree, row.counter, tvb(at, 1))
    return add_list(tree, tvb, at + 1, count, row)
  elseif left < row.size * (row.times or 1) then
    return nil
  elseif row.times then
    return add_list(tree, tvb, at, row.times, row)
  end
  add_value(tree, row, tvb(at, row.size))
  return at + row.size
end

-- Adds the values of rows. Returns the offset after them, or nil, the name of the row that is cut off, and its offset.
function add_rows(tree, tvb, at, stop, list)
  local ended = false
  for _, row in ipairs(list) do
    local left = stop - at
    if row.needs and (ended or left < row.needs) then
      ended = true
    elseif not (row.newer and left == 0) then
      local after = add_row(tree, tvb, at, stop, row)
      if not after then return nil, row[1], at end
      at = after
    end
  end
  return at
end

-- Fields that every frame has, and those of the bytes that no row describes.
F.message = keep(ProtoField.string(KEY .. ".message", "Message"))
F.sender = keep(ProtoField.string(KEY .. ".sender", "Sender"))
F.response_in = keep(ProtoField.framenum(KEY .. ".response_in", "Response in", base.NONE, frametype.RESPONSE))
F.request_in = keep(ProtoField.framenum(KEY .. ".request_in", "Request in", base.NONE, frametype.REQUEST))
F.time = keep(ProtoField.relative_time(KEY .. ".time", "Time since the request"))
F.data = keep(ProtoField.bytes(KEY .. ".data", "Data"))
F.tail = keep(ProtoField.bytes(KEY .. ".tail", "Bytes after the known fields"))
F.noise = keep(ProtoField.bytes(KEY .. ".noise", "Noise"))

-- Bodies that are added by a function of their own, by the name of their message. It returns what `add_rows` returns.
local BY_HAND = {}

-- Adds a body, and says what is wrong with it.
local function add_body(tree, tvb, frame)
  local at, stop, message = frame.body, frame.stop, frame.message
  if not message then
    if at < stop then tree:add(F.data, tvb(at, stop - at)) end
    tree:add_proto_expert_info(frame.fault or E.unknown, frame.why or "Unknown message")
    return
  end
  local add = BY_HAND[message.name] or add_rows
  local after, name, from = add(tree, tvb, at, stop, message, frame)
  if not after then
    tree:add_proto_expert_info(E.short, string.format("%s ends before %s does", message.name, name))
    after = from
    if after < stop then tree:add(F.data, tvb(after, stop - after)) end
  elseif after < stop then
    local item = tree:add(F.tail, tvb(after, stop - after))
    item:add_proto_expert_info(E.trailing, string.format("%d bytes follow the known fields", stop - after))
  end
end

-- Frames of the capture, with what was found about them when they were first seen.
local seen, waiting, held, joined

function proto.init()
  seen, waiting, held, joined = {}, {}, {}, {}
end

-- Name of the line between a host and a device, the same for both directions.
local function line_of(pinfo)
  local a = tostring(pinfo.src) .. ":" .. tostring(pinfo.src_port)
  local b = tostring(pinfo.dst) .. ":" .. tostring(pinfo.dst_port)
  return a < b and a .. " " .. b or b .. " " .. a
end

-- What tells a frame from all others of the capture. A packet may end one buffer and begin another, both at offset 0.
local function id_of(pinfo, tvb, at, size)
  return table.concat({ pinfo.number, at, tvb:len(), tvb:raw(at, math.min(size, 16)) }, " ")
end

-- Finds the request of an answer and the answer to a request, which have the same tag, and shows them.
local function pair(tree, pinfo, id, frame)
  local entry = seen[id]
  if not entry then
    entry = { number = pinfo.number, time = pinfo.rel_ts, more = frame.more, frame = frame }
    seen[id] = entry
    local key = line_of(pinfo) .. " " .. frame.tag
    if frame.asks then
      waiting[key] = entry
    elseif frame.answers and waiting[key] then
      local request = waiting[key]
      entry.request = request
      entry.again = request.response and not request.last.more
      request.response = request.response or entry
      request.last = entry
    end
  end
  if entry.response then tree:add(F.response_in, entry.response.number):set_generated() end
  if entry.request then
    tree:add(F.request_in, entry.request.number):set_generated()
    local time = math.max(entry.time - entry.request.time, 0)
    tree:add(F.time, NSTime.new(math.floor(time), math.floor(time % 1 * 1e9))):set_generated()
    if entry.again then tree:add_proto_expert_info(E.again) end
  elseif frame.answers and not frame.unasked then
    tree:add_proto_expert_info(E.unasked)
  end
  return entry.request and entry.request.frame
end

-- Sender, if something besides the message tells it.
local function told_sender(pinfo)
  if PORT and (pinfo.src_port == PORT) ~= (pinfo.dst_port == PORT) then
    return pinfo.src_port == PORT and "device" or "host"
  end
  if pinfo.p2p_dir == 0 then return "host" end
  if pinfo.p2p_dir == 1 then return "device" end
  return ({ "host", "device" })[proto.prefs.side]
end

-- Functions that each dissector has of its own.
-- next_frame(tvb, at): "frame" and its size, "noise" and its size, or "more" and the size that the frame will have.
-- read_frame(tvb, at, size, sender, pinfo): what the header of a frame says.
local next_frame, read_frame

local function show_frame(tvb, pinfo, root, at, size)
  local frame = read_frame(tvb, at, size, told_sender(pinfo), pinfo)
  local name = frame.message and frame.message.name or "Other"
  local tree = root:add(proto, tvb(at, size), string.format("%s, %s: %s", NAME, frame.sender, name))
  tree:add(F.message, name):set_generated()
  tree:add(F.sender, frame.sender):set_generated()
  frame.request = pair(tree, pinfo, id_of(pinfo, tvb, at, size), frame)
  local about = frame.request and frame.request.message
  if about and (name == "Reply" or name == "Ack") then
    name = name .. " to " .. about.name
    tree:set_text(string.format("%s, %s: %s", NAME, frame.sender, name))
  end
  add_rows(tree, tvb, at, frame.body, frame.header)
  if frame.message and frame.message.sub_row then add_value(tree, frame.message.sub_row, frame.sub) end
  add_body(tree, tvb, frame)
  if frame.finish then frame.finish(tree) end
  pinfo.cols.info:append(string.format(" %s %s", frame.sender == "host" and ">" or "<", name))
end

-- Dissects the frames of a piece of a stream. Returns the offset of a frame that is not complete, and its size.
local function show_frames(tvb, pinfo, root)
  local at = 0
  while at < tvb:len() do
    local what, size = next_frame(tvb, at)
    if what == "more" then return at, size end
    if what == "frame" then
      show_frame(tvb, pinfo, root, at, size)
    else
      local tree = root:add(proto, tvb(at, size), string.format("%s: %d bytes of noise", NAME, size))
      tree:add(F.noise, tvb(at, size)):add_proto_expert_info(E.noise)
    end
    at = at + size
  end
end

-- Joins the bytes that a record of a serial line left over with the next record of the same sender. A record that begins
-- with a marker begins a frame.
local function join(tvb, pinfo)
  if not MARKER then return tvb end
  local key = line_of(pinfo) .. " " .. tostring(told_sender(pinfo))
  if not pinfo.visited then
    if held[key] and tvb:raw():sub(1, #MARKER) ~= MARKER then joined[pinfo.number] = held[key] end
    held[key] = nil
  end
  local before = joined[pinfo.number]
  if not before then return tvb, key end
  return ByteArray.new(before .. tvb:raw(), true):tvb(NAME .. " joined"), key
end

local function dissect(tvb, pinfo, root)
  pinfo.cols.protocol = NAME
  pinfo.cols.info = ""
  local length = tvb:len()
  local data, key = join(tvb, pinfo)
  local at, size = show_frames(data, pinfo, root)
  if not at then return length end
  if pinfo.can_desegment > 0 then
    pinfo.desegment_offset = at
    pinfo.desegment_len = size and size - (data:len() - at) or DESEGMENT_ONE_MORE_SEGMENT
    return length
  end
  if key and not pinfo.visited then held[key] = data:raw(at) end
  local tree = root:add(proto, data(at), string.format("%s: a part of a frame", NAME))
  tree:add(F.data, data(at))
  tree:add_proto_expert_info(E.cut)
  return length
end
