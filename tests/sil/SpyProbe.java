import java.io.DataInput;
import java.io.IOException;
import java.io.PrintStream;
import java.lang.reflect.Array;
import java.lang.reflect.Field;
import java.lang.reflect.Modifier;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.spy.LCMTypeDatabase;

/**
 * lcm-spy without its window: finds the message types on the class path by lcm-spy's own type database, listens on URL
 * (argument 1) and prints each message as a line of JSON: channel, size_bytes, type_hash, type (null when no class has that
 * hash) and every field. Prints {"listening": true} first. Ends when its standard input does.
 */
public final class SpyProbe {
    private static final PrintStream out = System.out;

    public static void main(String[] args) throws IOException {
        System.setOut(System.err); // the type database reports to standard output
        LCMTypeDatabase types = new LCMTypeDatabase();
        new LCM(args[0]).subscribeAll((lcm, channel, message) -> print(types, channel, message));
        out.println("{\"listening\": true}");
        while (System.in.read() >= 0) {
        }
        System.exit(0);
    }

    private static void print(LCMTypeDatabase types, String channel, LCMDataInputStream message) {
        StringBuilder line = new StringBuilder("{\"channel\": ").append(quoted(channel));
        try {
            line.append(", \"size_bytes\": ").append(message.available());
            long hash = message.readLong();
            Class<?> type = types.getClassByFingerprint(hash);
            message.reset();
            line.append(", \"type_hash\": ").append(hash);
            line.append(", \"type\": ").append(type == null ? null : quoted(type.getName()));
            if (type != null) {
                line.append(", \"fields\": ");
                append(line, type.getConstructor(DataInput.class).newInstance(message));
            }
        } catch (ReflectiveOperationException | IOException e) {
            line.append(", \"error\": ").append(quoted(String.valueOf(e.getCause() != null ? e.getCause() : e)));
        }
        out.println(line.append('}'));
    }

    private static void append(StringBuilder line, Object value) throws IllegalAccessException {
        if (value instanceof Number || value instanceof Boolean) {
            line.append(value);
        } else if (value instanceof String) {
            line.append(quoted((String) value));
        } else if (value.getClass().isArray()) {
            line.append('[');
            for (int i = 0; i < Array.getLength(value); i++) {
                line.append(i > 0 ? ", " : "");
                append(line, Array.get(value, i));
            }
            line.append(']');
        } else {
            line.append('{');
            String separator = "";
            for (Field field : value.getClass().getFields()) {
                if (!Modifier.isStatic(field.getModifiers())) {
                    line.append(separator).append(quoted(field.getName())).append(": ");
                    append(line, field.get(value));
                    separator = ", ";
                }
            }
            line.append('}');
        }
    }

    private static String quoted(String text) {
        StringBuilder quoted = new StringBuilder("\"");
        for (char c : text.toCharArray()) {
            quoted.append(c < ' ' || c == '"' || c == '\\' ? String.format("\\u%04x", (int) c) : String.valueOf(c));
        }
        return quoted.append('"').toString();
    }
}
